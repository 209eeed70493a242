//! What adapters there are and what each can do, told without wgpu's types.

use serde::Serialize;

use super::context::{AdapterChoice, GpuContext, preference};

/// One adapter of this machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdapterReport {
    /// The name its driver gives.
    pub name: String,
    /// The interface it is reached by: `vulkan`, `gl`, `metal` or `dx12`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: String,
    /// The driver's name and version.
    pub driver: String,
    /// Whether it is the one that the choice leads to.
    pub chosen: bool,
    /// What it can do of that which the renderer can make use of.
    pub capabilities: Vec<CapabilityReport>,
    /// Its limits that matter here.
    pub limits: Vec<LimitReport>,
}

/// One capability and what hangs on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CapabilityReport {
    /// What it is.
    pub name: &'static str,
    /// Whether the adapter has it.
    pub available: bool,
    /// What happens without it.
    pub without: &'static str,
}

/// One limit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LimitReport {
    /// What is limited, with its unit.
    pub name: &'static str,
    /// The most there may be of it.
    pub value: u64,
}

/// Every adapter of this machine, in the order in which the choice prefers them; those that it rules
/// out come last. Empty on a machine without any.
pub fn survey_adapters(choice: &AdapterChoice) -> Vec<AdapterReport> {
    let mut adapters = GpuContext::adapters(&AdapterChoice::Best);
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        (!choice.accepts(&info), preference(&info))
    });
    let best_fits = adapters.first().is_some_and(|best| choice.accepts(&best.get_info()));
    let report = |(index, adapter)| report(adapter, index == 0 && best_fits);
    adapters.iter().enumerate().map(report).collect()
}

fn report(adapter: &wgpu::Adapter, chosen: bool) -> AdapterReport {
    let info = adapter.get_info();
    AdapterReport {
        name: info.name,
        backend: info.backend.to_string(),
        kind: kind_name(info.device_type).to_owned(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        chosen,
        capabilities: capabilities(adapter),
        limits: limits(&adapter.limits()),
    }
}

fn kind_name(device_type: wgpu::DeviceType) -> &'static str {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu => "virtual",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "other",
    }
}

fn capabilities(adapter: &wgpu::Adapter) -> Vec<CapabilityReport> {
    let features = adapter.features();
    let rg32_drawable = adapter
        .get_texture_format_features(wgpu::TextureFormat::Rg32Float)
        .allowed_usages
        .contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
    let has = |feature| features.contains(feature);
    [
        (
            "float32 render targets",
            rg32_drawable,
            "the coordinate pass cannot draw: no terrain; choose another adapter",
        ),
        (
            "BC texture compression",
            has(wgpu::Features::TEXTURE_COMPRESSION_BC),
            "colours are expanded to RGBA8 on upload: four to eight times the bytes",
        ),
        (
            "timestamp queries",
            has(wgpu::Features::TIMESTAMP_QUERY),
            "times on the GPU are not measured: gpu_ms stays empty",
        ),
        (
            "float32 filtering",
            has(wgpu::Features::FLOAT32_FILTERABLE),
            "nothing is lost: heights are filtered by the shaders themselves",
        ),
        (
            "storage writes from fragments",
            fragments_write(adapter),
            "--strategy texture-map is refused",
        ),
        (
            "wireframe (line polygons)",
            has(wgpu::Features::POLYGON_MODE_LINE),
            "the wireframe view is left out",
        ),
        ("shaders in f16", has(wgpu::Features::SHADER_F16), "terrain precision measures no f16"),
        (
            "shaders in f64",
            has(wgpu::Features::SHADER_F64),
            "terrain precision compares with f64 on the CPU alone",
        ),
    ]
    .map(|(name, available, without)| CapabilityReport { name, available, without })
    .into()
}

/// Whether vertices may read storage and fragments write it, as a texture map needs.
pub(super) fn fragments_write(adapter: &wgpu::Adapter) -> bool {
    let needed =
        wgpu::DownlevelFlags::FRAGMENT_WRITABLE_STORAGE.union(wgpu::DownlevelFlags::VERTEX_STORAGE);
    adapter.get_downlevel_capabilities().flags.contains(needed)
}

fn limits(limits: &wgpu::Limits) -> Vec<LimitReport> {
    [
        ("texture side (texels)", u64::from(limits.max_texture_dimension_2d)),
        ("texture layers", u64::from(limits.max_texture_array_layers)),
        ("buffer (bytes)", limits.max_buffer_size),
        ("storage binding (bytes)", limits.max_storage_buffer_binding_size),
    ]
    .map(|(name, value)| LimitReport { name, value })
    .into()
}
