//! How a camera that stands still comes to rest: frames until nothing changes, and what still does.

use super::FrameRecord;
use crate::CameraView;

/// Frames that a camera has to stand still with nothing missing before it counts as at rest: a region
/// seen late, and what tiles that have just arrived show of the ground, may ask for a few tiles more.
pub const FRAMES_TO_REST: usize = 8;

/// Frames after a jump until the picture is as sharp as it gets: 0 where the first one is. `None` where
/// the camera moved on before.
///
/// `views` and `records` are those of consecutive frames, the first that after the jump. A frame is not
/// sharp yet while tiles are missing, while tiles were chosen by what an earlier view saw, or while
/// tiles are still to come that were not known to be missing.
pub fn frames_until_sharp(views: &[CameraView], records: &[FrameRecord]) -> Option<u64> {
    let held = views.iter().take_while(|view| Some(*view) == views.first()).count();
    let records = &records[..held.min(records.len())];
    let is_waiting = |record: &FrameRecord| {
        record.tiles_missing > 0 || record.region_age_frames.is_some_and(|age| age > 0)
    };
    let waited = records.iter().rposition(is_waiting).map_or(0, |last| last + 1);
    let brought = records.iter().rposition(|record| record.tiles_new > 0).unwrap_or(0);
    let sharp = waited.max(brought);
    (sharp < records.len()).then_some(sharp as u64)
}

/// Tiles brought while the camera was at rest: none, if a still camera comes to rest as it should.
///
/// `views` and `records` are those of consecutive frames.
pub fn churn_at_rest(views: &[CameraView], records: &[FrameRecord]) -> u64 {
    let mut calm_frames = 0;
    let mut churn = 0;
    for (index, record) in records.iter().enumerate().skip(1) {
        if views[index] != views[index - 1] {
            calm_frames = 0;
            continue;
        }
        if calm_frames >= FRAMES_TO_REST {
            churn += record.tiles_new;
        }
        let is_calm = records[index - 1].tiles_missing == 0 && record.tiles_missing == 0;
        calm_frames = if is_calm { calm_frames + 1 } else { 0 };
    }
    churn
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn view(x: f64) -> CameraView {
        CameraView {
            eye: DVec3::new(x, 0.0, 100.0),
            heading_deg: 0.0,
            pitch_deg: 0.0,
            fov_y_deg: 50.0,
            viewport_px: [8, 8],
        }
    }

    /// Frames of (tiles missing, tiles new, age of the region).
    fn records(frames: &[(u64, u64, Option<u64>)]) -> Vec<FrameRecord> {
        let record = |&(tiles_missing, tiles_new, region_age_frames)| FrameRecord {
            tiles_missing,
            tiles_new,
            region_age_frames,
            ..Default::default()
        };
        frames.iter().map(record).collect()
    }

    fn until_sharp(frames: &[(u64, u64, Option<u64>)]) -> Option<u64> {
        frames_until_sharp(&vec![view(0.0); frames.len()], &records(frames))
    }

    #[test]
    fn a_picture_is_sharp_when_nothing_is_still_to_come() {
        let calm = (0, 0, None);
        assert_eq!(until_sharp(&[calm, calm]), Some(0));
        assert_eq!(until_sharp(&[(3, 0, None), (1, 2, None), (0, 1, None), calm]), Some(2));
        let by_old_region = [(0, 0, Some(2)), (0, 0, Some(3)), (4, 0, Some(0)), (0, 4, Some(0))];
        assert_eq!(until_sharp(&by_old_region), Some(3), "not before the region is its own");
        assert_eq!(until_sharp(&[calm, calm, (0, 2, None), calm]), Some(2), "found late");
        assert_eq!(until_sharp(&[(1, 0, None), (1, 0, None)]), None);
        assert_eq!(until_sharp(&[]), None);
    }

    #[test]
    fn only_the_frames_of_one_view_count() {
        let views = [view(1.0), view(1.0), view(2.0), view(1.0)];
        let frames = records(&[(1, 0, None), (0, 1, None), (7, 0, None), (7, 0, None)]);
        assert_eq!(frames_until_sharp(&views, &frames), Some(1));
        assert_eq!(frames_until_sharp(&views[..1], &frames[..1]), None, "moved on too early");
    }

    #[test]
    fn tiles_that_come_at_rest_are_churn_and_others_are_not() {
        let mut frames = vec![(0, 0, None); 24];
        frames[1] = (2, 0, None);
        frames[2] = (0, 2, None);
        assert_eq!(churn_at_rest(&[view(0.0); 24], &records(&frames)), 0);
        frames[20] = (0, 3, None);
        assert_eq!(churn_at_rest(&[view(0.0); 24], &records(&frames)), 3);
        let mut views = [view(0.0); 24];
        views[16..].fill(view(1.0));
        assert_eq!(churn_at_rest(&views, &records(&frames)), 0, "it had just moved");
    }
}
