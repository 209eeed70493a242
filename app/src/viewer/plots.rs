//! The frames just past, plotted: bytes by cause and times.

use std::collections::VecDeque;

use egui::{Color32, RichText, Ui};
use egui_plot::{FilledArea, GridInput, GridMark, Line, Plot, PlotPoints};
use terrain_core::measure::FrameRecord;

/// Frames that are kept and shown.
const FRAMES_SHOWN: usize = 240;
const PLOT_HEIGHT: f32 = 100.0;

/// The records of the frames just past, the oldest first.
#[derive(Default)]
pub struct FrameHistory {
    records: VecDeque<FrameRecord>,
}

/// A cause of bytes: its name, its colour and how many there were.
type Cause = (&'static str, Color32, fn(&FrameRecord) -> u64);

/// Bytes between disk, CPU and GPU, stacked from the bottom in this order.
const CAUSES: [Cause; 5] = [
    ("DEM", Color32::from_rgb(0xd9, 0x7b, 0x3c), |record| record.upload_dem_bytes),
    ("DOM", Color32::from_rgb(0x4f, 0x9d, 0x5d), |record| record.upload_dom_bytes),
    ("tables", Color32::from_rgb(0x5b, 0x8f, 0xd0), |record| record.upload_table_bytes),
    ("mesh, parameters", Color32::from_rgb(0xb4, 0x7c, 0xc7), |record| {
        record.upload_mesh_bytes + record.upload_uniform_bytes
    }),
    ("readback", Color32::from_rgb(0xc9, 0xb4, 0x4a), |record| record.readback_bytes),
];

/// Name and colour of the line of bytes read from disk.
const DISK: (&str, Color32) = ("disk", Color32::LIGHT_GRAY);

/// Names and colours of the times.
const TIMES: [(&str, Color32); 3] = [
    ("frame", Color32::LIGHT_GRAY),
    ("CPU", Color32::from_rgb(0x5b, 0x8f, 0xd0)),
    ("GPU", Color32::from_rgb(0xd9, 0x7b, 0x3c)),
];

impl FrameHistory {
    /// Adds a frame; the oldest makes room.
    pub fn push(&mut self, record: FrameRecord) {
        if self.records.len() == FRAMES_SHOWN {
            self.records.pop_front();
        }
        self.records.push_back(record);
    }

    /// The last frame.
    pub fn last(&self) -> Option<&FrameRecord> {
        self.records.back()
    }

    /// Mean of all bytes a frame over the frames kept, disk left out.
    pub fn mean_bytes(&self) -> f64 {
        let bytes: u64 = self.records.iter().map(|r| r.upload_bytes + r.readback_bytes).sum();
        bytes as f64 / self.records.len().max(1) as f64
    }

    /// Plots bytes a frame by cause, stacked, and those read from disk as a line.
    pub fn show_bytes(&self, ui: &mut Ui) {
        let frames = self.frame_numbers();
        let stacks = self.stacked_kib();
        let disk = self.line(|record| record.disk_bytes as f64 / 1024.0);
        captions(ui, CAUSES.iter().map(|(name, colour, _)| (*name, *colour)).chain([DISK]));
        plot("bytes", "KiB").show(ui, |plot| {
            for (index, (name, colour, _)) in CAUSES.iter().enumerate() {
                let area = FilledArea::new(*name, &frames, &stacks[index], &stacks[index + 1]);
                plot.add(area.fill_color(*colour));
            }
            plot.line(Line::new(DISK.0, disk).color(DISK.1));
        });
    }

    /// Plots the frames' times.
    pub fn show_times(&self, ui: &mut Ui) {
        let lines = [
            self.line(|record| record.frame_ms),
            self.line(|record| record.cpu_ms),
            self.line(|record| record.gpu_ms.unwrap_or(f64::NAN)),
        ];
        captions(ui, TIMES);
        plot("times", "ms").show(ui, |plot| {
            for ((name, colour), line) in TIMES.into_iter().zip(lines) {
                plot.line(Line::new(name, line).color(colour));
            }
        });
    }

    fn frame_numbers(&self) -> Vec<f64> {
        (0..self.records.len()).map(|index| index as f64).collect()
    }

    fn line(&self, value: impl Fn(&FrameRecord) -> f64) -> PlotPoints<'static> {
        self.records.iter().enumerate().map(|(x, record)| [x as f64, value(record)]).collect()
    }

    /// Running sums of the causes in KiB: element 0 is all zeros, the last one the sum of all.
    fn stacked_kib(&self) -> Vec<Vec<f64>> {
        let mut stacks = vec![vec![0.0; self.records.len()]];
        for (_, _, bytes) in &CAUSES {
            let below = &stacks[stacks.len() - 1];
            let kib = |record| bytes(record) as f64 / 1024.0;
            stacks.push(self.records.iter().zip(below).map(|(r, sum)| sum + kib(r)).collect());
        }
        stacks
    }
}

fn plot(id: &'static str, unit: &'static str) -> Plot<'static> {
    Plot::new(id)
        .height(PLOT_HEIGHT)
        .include_y(0.0)
        .include_x(0.0)
        .include_x(FRAMES_SHOWN as f64)
        .show_axes([false, true])
        .y_axis_min_width(64.0)
        .y_grid_spacer(grid_marks)
        .show_grid([false, true])
        .y_axis_formatter(move |mark, _| format!("{} {unit}", mark.value))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
}

/// Lines at round numbers, four intervals at the most.
fn grid_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let step_size = round_step((high - low) / 4.0);
    let first = (low / step_size).ceil() as i64;
    let last = (high / step_size).floor() as i64;
    (first..=last).map(|n| GridMark { value: n as f64 * step_size, step_size }).collect()
}

/// The smallest of 1, 2, 5, 10, 20, .. (and their tenths and so on) not below the number; 1 where
/// that is not positive.
fn round_step(least: f64) -> f64 {
    if !(least.is_finite() && least > 0.0) {
        return 1.0;
    }
    let decade = 10.0_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|n| n * decade).into_iter().find(|step| *step >= least).unwrap_or(1.0)
}

/// What the colours of a plot mean, each word in its colour.
fn captions(ui: &mut Ui, names: impl IntoIterator<Item = (&'static str, Color32)>) {
    ui.horizontal_wrapped(|ui| {
        for (name, colour) in names {
            ui.label(RichText::new(name).small().color(colour));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stacks_add_up_to_all_bytes_moved() {
        let mut history = FrameHistory::default();
        history.push(FrameRecord {
            upload_dem_bytes: 1024,
            upload_dom_bytes: 2048,
            upload_table_bytes: 512,
            upload_mesh_bytes: 256,
            upload_uniform_bytes: 256,
            upload_bytes: 4096,
            readback_bytes: 1024,
            ..Default::default()
        });
        let stacks = history.stacked_kib();
        assert_eq!(stacks.len(), CAUSES.len() + 1);
        assert_eq!(stacks[CAUSES.len()], [5.0]);
        assert_eq!(history.mean_bytes(), 5120.0);
    }

    #[test]
    fn grid_lines_are_few_and_round() {
        let marks = |low, high| {
            let input = GridInput { bounds: (low, high), base_step_size: 1.0 };
            grid_marks(input).iter().map(|mark| mark.value).collect::<Vec<_>>()
        };
        assert_eq!(marks(-10.0, 260.0), [0.0, 100.0, 200.0]);
        assert_eq!(marks(0.0, 5_400.0), [0.0, 2_000.0, 4_000.0]);
        assert_eq!(round_step(0.07), 0.1);
        assert_eq!(round_step(0.0), 1.0);
        assert_eq!(round_step(f64::NAN), 1.0);
    }

    #[test]
    fn the_oldest_frames_make_room() {
        let mut history = FrameHistory::default();
        for frame in 0..FRAMES_SHOWN as u64 + 5 {
            history.push(FrameRecord { frame, ..Default::default() });
        }
        assert_eq!(history.records.len(), FRAMES_SHOWN);
        assert_eq!(history.records[0].frame, 5);
    }
}
