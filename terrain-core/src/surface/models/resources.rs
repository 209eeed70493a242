//! What a glTF file names beside its numbers: buffers and images, within the file, in data URIs or in files
//! beside it.

use std::io::Read;
use std::path::{Path, PathBuf};

use gltf::Document;
use image::{ImageFormat, ImageReader, Limits};

use super::accessors::Buffers;
use super::model::ModelImage;

/// Most bytes of a file beside the model.
const MOST_BYTES: u64 = 1 << 31;
/// Longest side of an image, and most bytes its decoding may take.
const MOST_TEXELS_A_SIDE: u32 = 16_384;
const MOST_IMAGE_BYTES: u64 = 1 << 30;

/// The bytes of all buffers. One that cannot be had is a reason in words, for whoever needs it.
pub(super) fn buffers(document: &Document, mut blob: Option<Vec<u8>>, path: &Path) -> Buffers {
    let bytes_of = |buffer: gltf::Buffer<'_>| {
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => {
                blob.take().ok_or_else(|| "its binary chunk is missing".to_owned())?
            }
            gltf::buffer::Source::Uri(uri) => bytes_of_uri(uri, path)?,
        };
        match bytes.len() >= buffer.length() {
            true => Ok(bytes),
            false => Err(format!(
                "a buffer of {} bytes holds only {}: the file is cut short",
                buffer.length(),
                bytes.len()
            )),
        }
    };
    Buffers(document.buffers().map(bytes_of).collect())
}

/// Decodes the image of this number.
///
/// # Errors
/// In words that name the image.
pub(super) fn image(
    document: &Document,
    index: usize,
    buffers: &Buffers,
    path: &Path,
) -> Result<ModelImage, String> {
    let json = document.as_json().images.get(index).ok_or("an image is missing")?;
    let bytes = if let Some(view) = &json.buffer_view {
        let view = document.views().nth(view.value()).ok_or("an image's view is missing")?;
        buffers.view(&view).map(<[u8]>::to_vec)
    } else if let Some(uri) = &json.uri {
        bytes_of_uri(uri, path)
    } else {
        Err("neither a view nor a file is named".to_owned())
    };
    let is_file = |uri: &&String| !uri.starts_with("data:");
    let name = json.uri.as_ref().filter(is_file).or(json.name.as_ref());
    let named = name.map_or_else(|| format!("image {index}"), |name| format!("image {name}"));
    bytes.and_then(|bytes| decode(&bytes)).map_err(|reason| format!("{named}: {reason}"))
}

fn decode(bytes: &[u8]) -> Result<ModelImage, String> {
    let reader = ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|error| error.to_string())?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("neither PNG nor JPEG".to_owned());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_TEXELS_A_SIDE);
    limits.max_image_height = Some(MOST_TEXELS_A_SIDE);
    limits.max_alloc = Some(MOST_IMAGE_BYTES);
    reader.limits(limits);
    let rgba = reader.decode().map_err(|error| error.to_string())?.into_rgba8();
    let size_texels = [rgba.width(), rgba.height()];
    match size_texels.contains(&0) {
        true => Err("no texels".to_owned()),
        false => Ok(ModelImage { size_texels, rgba: rgba.into_raw().into() }),
    }
}

fn bytes_of_uri(uri: &str, model: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        return bytes_of_data_uri(data);
    }
    if uri.contains("://") {
        return Err(format!("{uri}: only files beside the model are read"));
    }
    let path = file_beside(model, uri)?;
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let file = std::fs::File::open(&path).map_err(failed)?;
    let size = file.metadata().map_err(failed)?.len();
    if size > MOST_BYTES {
        return Err(format!("{}: {size} bytes are too many", path.display()));
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

fn file_beside(model: &Path, uri: &str) -> Result<PathBuf, String> {
    let name = percent_decoded(uri).ok_or_else(|| format!("{uri}: not a file's name"))?;
    Ok(model.parent().unwrap_or_else(|| Path::new("")).join(name))
}

/// The text with its escapes (RFC 3986) resolved; `None` where they are none.
fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        if first != b'%' {
            bytes.push(first);
            continue;
        }
        let (digits, after) = rest.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
        rest = after;
    }
    String::from_utf8(bytes).ok()
}

/// The bytes in a data URI (RFC 2397) behind its scheme.
fn bytes_of_data_uri(data: &str) -> Result<Vec<u8>, String> {
    let bytes = data
        .split_once(',')
        .and_then(|(kind, text)| kind.ends_with(";base64").then(|| base64_decoded(text)).flatten());
    bytes.ok_or_else(|| "a data URI holds no base64".to_owned())
}

/// The bytes that base64 text stands for (RFC 4648); `None` where it is none.
fn base64_decoded(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for letter in text.trim_end_matches('=').bytes() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_and_base64_are_resolved() {
        assert_eq!(percent_decoded("a%20b.png").as_deref(), Some("a b.png"));
        assert_eq!(percent_decoded("a%2"), None);
        assert_eq!(percent_decoded("%ff"), None, "not UTF-8");
        for (text, bytes) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9vYmFy", "foobar")] {
            assert_eq!(base64_decoded(text).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(base64_decoded("Zm9*"), None);
    }
}
