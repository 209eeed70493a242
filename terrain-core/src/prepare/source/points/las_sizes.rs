//! Whether the sizes a LAS or LAZ file states can be true: readers ask for so much memory.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// Bytes of the header that are looked at: that of LAS 1.4, longer than older ones.
const HEADER_BYTES: usize = 375;
/// Bytes of an extended record before its data.
const EXTENDED_RECORD_BYTES: u64 = 60;

/// Checks where a file's points, its extended records and its table of compressed chunks lie.
pub fn check_sizes(file: &mut File) -> Result<(), String> {
    let failed = |error: std::io::Error| error.to_string();
    let file_bytes = file.metadata().map_err(failed)?.len();
    let mut header = Vec::new();
    Read::by_ref(file).take(HEADER_BYTES as u64).read_to_end(&mut header).map_err(failed)?;
    // What is shorter is refused by the reader.
    header.resize(HEADER_BYTES, 0);
    let points_at = u64::from(u32_at(&header, 96));
    if points_at > file_bytes {
        return Err(format!("its points begin at byte {points_at} of {file_bytes}"));
    }
    if header[25] >= 4 {
        let (first, count) = (u64_at(&header, 235), u32_at(&header, 243));
        check_extended_records(file, file_bytes, first, count)?;
    }
    if header[104] & 0x80 != 0 {
        check_chunks(file, file_bytes, points_at)?;
    }
    Ok(())
}

fn check_extended_records(
    file: &mut File,
    file_bytes: u64,
    first: u64,
    count: u32,
) -> Result<(), String> {
    let mut at = first;
    for _ in 0..count {
        let bytes = u64_at(&read_at(file, at.saturating_add(20), 8)?, 0);
        at = at.saturating_add(EXTENDED_RECORD_BYTES).saturating_add(bytes);
        if at > file_bytes {
            return Err(format!("a record of {bytes} bytes in a file of {file_bytes}"));
        }
    }
    Ok(())
}

/// The table's place stands before the points, or, where the writer could not go back, at the end.
fn check_chunks(file: &mut File, file_bytes: u64, points_at: u64) -> Result<(), String> {
    const NOT_WRITTEN: u64 = u64::MAX;
    let mut table_at = u64_at(&read_at(file, points_at, 8)?, 0);
    if table_at == NOT_WRITTEN {
        table_at = u64_at(&read_at(file, file_bytes.saturating_sub(8), 8)?, 0);
    }
    let chunks = u64::from(u32_at(&read_at(file, table_at.saturating_add(4), 4)?, 0));
    if chunks > file_bytes {
        return Err(format!("{chunks} chunks of points in a file of {file_bytes} bytes"));
    }
    Ok(())
}

fn read_at(file: &mut File, at: u64, count: usize) -> Result<Vec<u8>, String> {
    let mut bytes = vec![0; count];
    file.seek(SeekFrom::Start(at))
        .and_then(|_| file.read_exact(&mut bytes))
        .map_err(|_| format!("it ends before byte {at}"))?;
    Ok(bytes)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let mut value = [0; 4];
    value.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(value)
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let mut value = [0; 8];
    value.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(value)
}
