//! The numbers in a glTF file's buffers, read so that no statement of the file about sizes is believed: every
//! byte is looked up within its bounds, and nothing is allocated before the bytes for it are known to be there.

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;

/// The bytes of a file's buffers, or why one cannot be had.
pub(super) struct Buffers(pub Vec<Result<Vec<u8>, String>>);

/// Most elements of an accessor that no bytes stand for: those of an accessor without a view are all 0.
const MOST_WITHOUT_BYTES: usize = 1 << 24;

impl Buffers {
    /// The bytes of a view.
    pub fn view(&self, view: &View<'_>) -> Result<&[u8], String> {
        let bytes = match self.0.get(view.buffer().index()) {
            Some(Ok(bytes)) => bytes,
            Some(Err(reason)) => return Err(reason.clone()),
            None => return Err("a buffer is missing".to_owned()),
        };
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| bytes.get(view.offset()..end))
            .ok_or_else(|| format!("a view of {} bytes reaches beyond its buffer", view.length()))
    }

    /// Vectors of `N` floats; whole numbers are turned into floats, by the range of their type where the file
    /// says so.
    pub fn vectors<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[f32; N]>, String> {
        let kind = accessor.data_type();
        if accessor.dimensions().multiplicity() != N {
            return Err(format!("{:?} where vectors of {N} are due", accessor.dimensions()));
        }
        let is_normalised = accessor.normalized();
        self.elements(accessor, N * component_bytes(kind), |bytes| {
            std::array::from_fn(|axis| component(bytes, axis, kind, is_normalised))
        })
    }

    /// Whole numbers.
    pub fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, String> {
        let kind = accessor.data_type();
        let is_whole = matches!(kind, DataType::U8 | DataType::U16 | DataType::U32);
        if !is_whole || accessor.dimensions() != Dimensions::Scalar {
            return Err(format!("{:?} of {kind:?} where indices are due", accessor.dimensions()));
        }
        self.elements(accessor, component_bytes(kind), |bytes| whole(bytes, kind))
    }

    fn elements<T: Clone + ElementDefault>(
        &self,
        accessor: &Accessor<'_>,
        element_bytes: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let count = accessor.count();
        let mut values = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(element_bytes).max(1);
                let bytes =
                    self.strided(&view, accessor.offset(), (stride, element_bytes), count)?;
                bytes.map(&decode).collect()
            }
            None if count <= MOST_WITHOUT_BYTES => vec![T::ZERO; count],
            None => return Err(format!("{count} elements without bytes")),
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, count) = (sparse.indices(), sparse.count());
            let kind = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => DataType::U8,
                gltf::accessor::sparse::IndexType::U16 => DataType::U16,
                gltf::accessor::sparse::IndexType::U32 => DataType::U32,
            };
            let size = component_bytes(kind);
            let places = self.strided(&indices.view(), indices.offset(), (size, size), count)?;
            let replaced = sparse.values();
            let sizes = (element_bytes, element_bytes);
            let elements = self.strided(&replaced.view(), replaced.offset(), sizes, count)?;
            for (place, element) in places.zip(elements) {
                let place = whole(place, kind) as usize;
                let value = values.get_mut(place).ok_or("a sparse index is out of range")?;
                *value = decode(element);
            }
        }
        Ok(values)
    }

    /// `count` elements of a view, `stride` bytes from one to the next.
    fn strided<'a>(
        &'a self,
        view: &View<'_>,
        offset: usize,
        (stride, element_bytes): (usize, usize),
        count: usize,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, String> {
        let bytes = self.view(view)?;
        let length = count
            .checked_sub(1)
            .map_or(Some(0), |steps| steps.checked_mul(stride)?.checked_add(element_bytes));
        let end = length.and_then(|length| offset.checked_add(length));
        let bytes = end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            format!("{count} elements of {element_bytes} bytes reach beyond their view")
        })?;
        Ok((0..count).map(move |index| &bytes[index * stride..index * stride + element_bytes]))
    }
}

/// What elements of an accessor without bytes are.
trait ElementDefault {
    const ZERO: Self;
}

impl<const N: usize> ElementDefault for [f32; N] {
    const ZERO: Self = [0.0; N];
}

impl ElementDefault for u32 {
    const ZERO: Self = 0;
}

fn component_bytes(kind: DataType) -> usize {
    match kind {
        DataType::I8 | DataType::U8 => 1,
        DataType::I16 | DataType::U16 => 2,
        DataType::U32 | DataType::F32 => 4,
    }
}

/// The first bytes of a component; 0 beyond the element.
fn word<const BYTES: usize>(bytes: &[u8], index: usize) -> [u8; BYTES] {
    let first = index * BYTES;
    bytes.get(first..).and_then(|rest| rest.first_chunk().copied()).unwrap_or([0; BYTES])
}

fn component(bytes: &[u8], index: usize, kind: DataType, is_normalised: bool) -> f32 {
    let (value, most) = match kind {
        DataType::F32 => return f32::from_le_bytes(word(bytes, index)),
        DataType::I8 => (i8::from_le_bytes(word(bytes, index)) as f32, 127.0),
        DataType::U8 => (u8::from_le_bytes(word(bytes, index)) as f32, 255.0),
        DataType::I16 => (i16::from_le_bytes(word(bytes, index)) as f32, 32_767.0),
        DataType::U16 => (u16::from_le_bytes(word(bytes, index)) as f32, 65_535.0),
        DataType::U32 => (u32::from_le_bytes(word(bytes, index)) as f32, u32::MAX as f32),
    };
    if is_normalised { (value / most).max(-1.0) } else { value }
}

fn whole(bytes: &[u8], kind: DataType) -> u32 {
    match kind {
        DataType::U8 => u32::from(u8::from_le_bytes(word(bytes, 0))),
        DataType::U16 => u32::from(u16::from_le_bytes(word(bytes, 0))),
        _ => u32::from_le_bytes(word(bytes, 0)),
    }
}
