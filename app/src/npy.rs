//! Arrays in NumPy's file format.

use std::io::Write;
use std::path::Path;

use anyhow::Context;

/// Writes a float64 array of this shape, its last axis running fastest (NumPy's `.npy`, version 1.0:
/// magic, version, length of the header, the header padded to 64 bytes, then the numbers).
///
/// # Errors
/// Where the file cannot be written; the error names it.
pub fn write_f64<const N: usize>(
    path: &Path,
    shape: [usize; N],
    values: impl IntoIterator<Item = f64>,
) -> anyhow::Result<()> {
    let write = || -> std::io::Result<()> {
        let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
        file.write_all(&header(&shape))?;
        for value in values {
            file.write_all(&value.to_le_bytes())?;
        }
        file.flush()
    };
    write().with_context(|| format!("{}: cannot write the array", path.display()))
}

fn header(shape: &[usize]) -> Vec<u8> {
    const PREAMBLE: usize = 10;
    let sides: Vec<String> = shape.iter().map(|side| format!("{side},")).collect();
    let sides = sides.join(" ");
    let mut text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({sides}), }}");
    // The header ends with a line break, at a multiple of 64 bytes.
    let length = (PREAMBLE + text.len() + 1).next_multiple_of(64) - PREAMBLE;
    text.extend(std::iter::repeat_n(' ', length - 1 - text.len()));
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    // A shape has a few numbers: the header is far below the 65535 bytes its length can tell.
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(text.into_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_what_the_format_says() {
        let folder = std::env::temp_dir().join(format!("terrain-npy-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.npy");
        write_f64(&path, [1, 2, 3], [1.0, -2.5, f64::NAN, 1e7, 0.0, 6.0]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        let expected = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2, 3,), }";
        assert_eq!(header.trim_end(), expected);
        assert!(header.ends_with('\n'));
        let numbers: Vec<f64> = bytes[10 + length..]
            .chunks_exact(8)
            .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap()))
            .collect();
        assert_eq!(numbers.len(), 6);
        assert!(numbers[2].is_nan() && numbers[1] == -2.5 && numbers[3] == 1e7);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = write_f64(Path::new("/nowhere/at/all.npy"), [1], [0.0]).unwrap_err();
        assert!(format!("{error:#}").contains("/nowhere/at/all.npy"));
    }
}
