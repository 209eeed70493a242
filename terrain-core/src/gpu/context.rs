use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

use super::adapter_survey::fragments_write;

/// Which GPU to use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The best there is: a discrete GPU, else an integrated one, else software.
    #[default]
    Best,
    /// Any adapter driven through Vulkan.
    Vulkan,
    /// Any adapter driven through OpenGL.
    Gl,
    /// A software implementation, such as Mesa's lavapipe.
    Cpu,
    /// The first adapter whose name holds this text, whatever the case of its letters.
    Named(String),
}

impl FromStr for AdapterChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text.to_lowercase().as_str() {
            "best" => Self::Best,
            "vulkan" => Self::Vulkan,
            "gl" => Self::Gl,
            "cpu" => Self::Cpu,
            _ => Self::Named(text.to_owned()),
        })
    }
}

impl std::fmt::Display for AdapterChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Best => "best",
            Self::Vulkan => "vulkan",
            Self::Gl => "gl",
            Self::Cpu => "cpu",
            Self::Named(name) => name,
        })
    }
}

impl AdapterChoice {
    fn backends(&self) -> wgpu::Backends {
        match self {
            Self::Vulkan => wgpu::Backends::VULKAN,
            Self::Gl => wgpu::Backends::GL,
            _ => wgpu::Backends::all(),
        }
    }

    pub(super) fn accepts(&self, info: &wgpu::AdapterInfo) -> bool {
        match self {
            Self::Best => true,
            Self::Vulkan => info.backend == wgpu::Backend::Vulkan,
            Self::Gl => info.backend == wgpu::Backend::Gl,
            Self::Cpu => info.device_type == wgpu::DeviceType::Cpu,
            Self::Named(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
        }
    }
}

/// Why there is no GPU to draw with.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver offers an adapter that fits the choice.
    #[error(
        "no graphics adapter for --adapter {choice} (found: {found}); \
         install a Vulkan driver, on Debian and Ubuntu the package mesa-vulkan-drivers"
    )]
    NoAdapter {
        /// What was asked for.
        choice: String,
        /// The adapters there are, or "none".
        found: String,
    },
    /// The adapter lacks something without which nothing can be drawn.
    #[error("{adapter} cannot draw terrain: {reason}; try another with --adapter")]
    Unsuitable {
        /// The adapter's name.
        adapter: String,
        /// What it lacks.
        reason: String,
    },
    /// The driver refused to open the device.
    #[error("{adapter} could not be opened: {reason}")]
    Device {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The device was lost, or reported an error it could not recover from.
    #[error("the graphics device failed: {0}")]
    Lost(String),
}

/// An open GPU.
pub struct GpuContext {
    /// The entry to the drivers.
    pub instance: wgpu::Instance,
    /// The chosen adapter.
    pub adapter: wgpu::Adapter,
    /// The open device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    failure: Arc<Mutex<Option<String>>>,
}

impl GpuContext {
    /// Features that are used where they exist; none is required.
    pub const OPTIONAL_FEATURES: wgpu::Features = wgpu::Features::TEXTURE_COMPRESSION_BC
        .union(wgpu::Features::TIMESTAMP_QUERY)
        .union(wgpu::Features::POLYGON_MODE_LINE)
        .union(wgpu::Features::SHADER_F16)
        .union(wgpu::Features::SHADER_F64);

    /// The entry to the drivers for this choice. Needed before the context only to make a surface.
    pub fn instance(choice: &AdapterChoice) -> wgpu::Instance {
        wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: choice.backends(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        })
    }

    /// Every adapter the drivers offer.
    pub fn adapters(choice: &AdapterChoice) -> Vec<wgpu::Adapter> {
        pollster::block_on(Self::instance(choice).enumerate_adapters(choice.backends()))
    }

    /// Opens a GPU without a window.
    ///
    /// # Errors
    /// [`GpuError`] where no adapter fits the choice or the driver refuses.
    pub fn headless(choice: &AdapterChoice) -> Result<Self, GpuError> {
        Self::new(Self::instance(choice), choice, None)
    }

    /// Opens a GPU that can present to `surface`, which must come from the same `instance`.
    ///
    /// # Errors
    /// [`GpuError`] where no adapter fits the choice or the driver refuses.
    pub fn new(
        instance: wgpu::Instance,
        choice: &AdapterChoice,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Self, GpuError> {
        let adapter = choose_adapter(&instance, choice, surface)?;
        let name = adapter.get_info().name;
        check_suitable(&adapter, &name)?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("terrain"),
            required_features: adapter.features() & Self::OPTIONAL_FEATURES,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::Device { adapter: name, reason: error.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        report_failures(&device, &failure);
        Ok(Self { instance, adapter, device, queue, failure })
    }

    /// Whether a texture map can be drawn: vertices read storage and fragments write it.
    pub fn can_map_textures(&self) -> bool {
        fragments_write(&self.adapter)
    }

    /// The adapter's name with the interface it is reached by and its driver, for records.
    pub fn adapter_name(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({}, {})", info.name, info.backend, info.driver_info)
    }

    /// Whether the adapter is a program on the CPU, such as Mesa's lavapipe.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Whether the device reads block-compressed textures.
    pub fn has_block_compression(&self) -> bool {
        self.device.features().contains(wgpu::Features::TEXTURE_COMPRESSION_BC)
    }

    /// Waits until the device has done all it was given.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where the device fails meanwhile.
    pub fn wait(&self) -> Result<(), GpuError> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited.map(drop).map_err(|error| GpuError::Lost(error.to_string()))
    }

    /// The first error the device has reported, if any: from there on nothing it draws is to be
    /// trusted, and every call says so.
    ///
    /// # Errors
    /// [`GpuError::Lost`] with the driver's words.
    pub fn check(&self) -> Result<(), GpuError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone();
        failure.map_or(Ok(()), |reason| Err(GpuError::Lost(reason)))
    }
}

fn choose_adapter(
    instance: &wgpu::Instance,
    choice: &AdapterChoice,
    surface: Option<&wgpu::Surface<'_>>,
) -> Result<wgpu::Adapter, GpuError> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(choice.backends()));
    let found = adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>();
    adapters.retain(|adapter| {
        choice.accepts(&adapter.get_info())
            && surface.is_none_or(|surface| adapter.is_surface_supported(surface))
    });
    adapters.sort_by_key(|adapter| preference(&adapter.get_info()));
    adapters.into_iter().next().ok_or_else(|| GpuError::NoAdapter {
        choice: choice.to_string(),
        found: if found.is_empty() { "none".to_owned() } else { found.join(", ") },
    })
}

/// Order of adapters, the best first: hardware before software, OpenGL last of a kind.
pub(super) fn preference(info: &wgpu::AdapterInfo) -> (u32, u32) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (kind, u32::from(info.backend == wgpu::Backend::Gl))
}

fn check_suitable(adapter: &wgpu::Adapter, name: &str) -> Result<(), GpuError> {
    let unsuitable =
        |reason: &str| GpuError::Unsuitable { adapter: name.to_owned(), reason: reason.to_owned() };
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Err(unsuitable("it has no compute shaders"));
    }
    let target = adapter.get_texture_format_features(wgpu::TextureFormat::Rg32Float);
    if !target.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
        return Err(unsuitable("it cannot draw into 32-bit float textures"));
    }
    Ok(())
}

/// Keeps the first failure for [`GpuContext::check`] instead of the default, which is to panic.
fn report_failures(device: &wgpu::Device, failure: &Arc<Mutex<Option<String>>>) {
    let keep = |slot: &Mutex<Option<String>>, reason: String| {
        slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
    };
    let slot = Arc::clone(failure);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.to_string())));
    let slot = Arc::clone(failure);
    device.set_device_lost_callback(move |reason, message| {
        keep(&slot, format!("the device is lost ({reason:?}) {message}"));
    });
}
