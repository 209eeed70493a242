use terrain_core::measure::report::HtmlReport;

use super::super::run_summary::RunSummary;

/// A column of a table with a row a run.
struct Column {
    title: &'static str,
    value: fn(&RunSummary) -> f64,
    decimals: usize,
}

const fn column(title: &'static str, decimals: usize, value: fn(&RunSummary) -> f64) -> Column {
    Column { title, value, decimals }
}

const COSTS: [Column; 10] = [
    column("ms a frame", 1, |run| run.frame_ms.mean),
    column("99 % (ms)", 1, |run| run.frame_ms.p99),
    column("CPU (ms)", 2, |run| run.cpu_ms.mean),
    column("GPU (ms)", 1, |run| run.gpu_ms.map_or(f64::NAN, |spread| spread.mean)),
    column("jank-sum (s)", 2, |run| run.jank_sum_ms / 1000.0),
    column("to the GPU (KB)", 1, RunSummary::upload_kib),
    column("back (KB)", 1, |run| run.bytes_a_frame.kib("readback")),
    column("disk (KB)", 1, |run| run.bytes_a_frame.kib("disk")),
    column("tiles", 0, |run| run.tiles_new as f64),
    column("late frames", 0, |run| run.frames_with_missing_tiles as f64),
];

const PICTURE_ERRORS: [Column; 5] = [
    column("FLIP mean", 4, |run| run.error("flip_mean")),
    column("FLIP 99 %", 3, |run| run.error("flip_p99")),
    column("PSNR (dB)", 1, |run| run.error("psnr_db")),
    column("SSIM", 3, |run| run.error("ssim")),
    column("popping (FLIP)", 4, |run| run.error("popping_flip_mean")),
];

const GROUND_ERRORS: [Column; 6] = [
    column("height RMSE (m)", 2, |run| run.error("height_rmse_m")),
    column("screen 50 % (px)", 3, |run| run.error("screen_error_px_p50")),
    column("99 % (px)", 2, |run| run.error("screen_error_px_p99")),
    column("silhouette (px)", 2, |run| run.error("silhouette_error_px")),
    column("swim 50 % (px)", 4, |run| run.error("swim_px_p50")),
    column("99 % (px)", 3, |run| run.error("swim_px_p99")),
];

const CAUSES: [Column; 9] = [
    column("heights", 2, |run| run.bytes_a_frame.kib("upload_dem")),
    column("imagery", 2, |run| run.bytes_a_frame.kib("upload_dom")),
    column("tables", 2, |run| run.bytes_a_frame.kib("upload_table")),
    column("meshes", 2, |run| run.bytes_a_frame.kib("upload_mesh")),
    column("uniforms", 2, |run| run.bytes_a_frame.kib("upload_uniform")),
    column("all to the GPU", 2, RunSummary::upload_kib),
    column("the first frame alone", 0, |run| run.first_frame_upload_bytes as f64 / 1024.0),
    column("a frame after it", 2, RunSummary::later_upload_kib),
    column("read back", 2, |run| run.bytes_a_frame.kib("readback")),
];

const TILES: [Column; 7] = [
    column("selected", 1, |run| run.tiles_a_frame["tiles_selected"]),
    column("left out as hidden", 1, |run| run.tiles_a_frame["tiles_hidden"]),
    column("new", 3, |run| run.tiles_a_frame["tiles_new"]),
    column("evicted", 3, |run| run.tiles_a_frame["tiles_evicted"]),
    column("missing", 2, |run| run.tiles_a_frame["tiles_missing"]),
    column("resident", 1, |run| run.tiles_a_frame["tiles_resident"]),
    column("age of the region (frames)", 2, |run| run.region_age_frames.unwrap_or(f64::NAN)),
];

const STAGES: [Column; 7] = [
    column("receive", 3, |run| run.stage_ms["receive_ms"]),
    column("select", 3, |run| run.stage_ms["select_ms"]),
    column("stream", 3, |run| run.stage_ms["stream_ms"]),
    column("set up", 3, |run| run.stage_ms["set_up_ms"]),
    column("draw", 3, |run| run.stage_ms["draw_ms"]),
    column("submit", 3, |run| run.stage_ms["submit_ms"]),
    column("CPU", 3, |run| run.cpu_ms.mean),
];

const PLAIN: [Column; 3] = [
    column("tiles as sent", 1, tiles_kib),
    column("the same as RGBA8 and 32-bit heights", 1, plain_kib),
    column("times", 2, |run| plain_kib(run) / tiles_kib(run)),
];

const WARM: [Column; 4] = [
    column("to the GPU, cold", 2, RunSummary::upload_kib),
    column("warm", 2, |run| warm_kib(run, "upload")),
    column("from disk, cold", 2, |run| run.bytes_a_frame.kib("disk")),
    column("warm", 2, |run| warm_kib(run, "disk")),
];

const REST: [Column; 2] = [
    column("frames until sharp after a jump", 1, |run| run.frames_until_sharp.unwrap_or(f64::NAN)),
    column("tiles brought at rest", 0, |run| run.churn_at_rest as f64),
];

/// What runs cost by cause and stage, what compression and caches save, and how they come to rest.
pub fn add_breakdown(report: &mut HtmlReport, runs: &[RunSummary]) {
    let typical = runs.iter().filter(|run| run.is_typical).collect::<Vec<_>>();
    report.heading("Where bytes and time go");
    report.subheading("Bytes a frame by cause (KB)");
    table(report, &CAUSES, &typical);
    report.paragraph(
        "The first frame brings the mesh, level 0 and, where frames wait for their tiles, all that the first \
         view needs. Where a flight is drawn with few of its frames each stands for a longer way, and what is \
         sent once weighs more than over the whole flight.",
    );
    report.subheading("Tiles a frame");
    table(report, &TILES, &typical);
    report.paragraph(
        "Tiles are selected for both layers together and counted for each where they move. Left out as \
         hidden: in the box of what is in view, but seen by no pixel.",
    );
    report.subheading("CPU time a frame by stage (ms)");
    table(report, &STAGES, &typical);
    report.subheading("Compression (KB of tiles a frame)");
    table(report, &PLAIN, &typical);
    report.paragraph(
        "The same texels, gutters included, at four bytes each. Where a run has none of its own to \
         count, because it sends something else than tiles, the columns are empty.",
    );
    if typical.iter().any(|run| run.warm_bytes_a_frame.is_some()) {
        report.subheading("Cold and warm caches (KB a frame)");
        table(report, &WARM, &typical);
        report.paragraph(
            "Cold: the flight begins with level 0 alone. Warm: it is flown again with what the first \
             time left in the caches of GPU and CPU. The operating system's own cache of files is left \
             as it is both times: bytes from disk are those asked of it.",
        );
    }
    report.subheading("Coming to rest");
    table(report, &REST, &typical);
    report.paragraph(
        "Frames until sharp: from a jump of the flight to the first frame to which nothing is still to \
         come, mean over the jumps; empty without jumps, where a jump was never sharp, and where frames \
         were left out. Tiles brought while the camera stood still and nothing had been missing for \
         eight frames must be 0.",
    );
}

/// Every run's figures.
pub fn add_raw_figures(report: &mut HtmlReport, runs: &[RunSummary], cost_note: &str) {
    let all = runs.iter().collect::<Vec<_>>();
    report.heading("Cost");
    table(report, &COSTS, &all);
    report.paragraph(cost_note);
    report.heading("Error of the pictures");
    table(report, &PICTURE_ERRORS, &all);
    report.paragraph("Means over the measured frames. Less is better, but for PSNR and SSIM.");
    report.heading("Error of the ground drawn");
    table(report, &GROUND_ERRORS, &all);
}

fn table(report: &mut HtmlReport, columns: &[Column], runs: &[&RunSummary]) {
    let has_flights = runs.iter().any(|run| run.flight != runs[0].flight);
    let names = if has_flights { &["flight", "run"][..] } else { &["run"] };
    let header = names.iter().copied().chain(columns.iter().map(|column| column.title));
    let row = |run: &&RunSummary| {
        let names = has_flights.then(|| run.flight.clone()).into_iter().chain([run.run.clone()]);
        let cell = |column: &Column| {
            let value = (column.value)(run);
            let known = || format!("{value:.*}", column.decimals);
            if value.is_finite() { known() } else { "–".to_owned() }
        };
        names.chain(columns.iter().map(cell)).collect::<Vec<_>>()
    };
    let rows = runs.iter().map(row).collect::<Vec<_>>();
    report.table(&header.collect::<Vec<_>>(), &rows);
}

fn tiles_kib(run: &RunSummary) -> f64 {
    run.bytes_a_frame.kib("upload_dem") + run.bytes_a_frame.kib("upload_dom")
}

fn plain_kib(run: &RunSummary) -> f64 {
    run.plain_tile_bytes_a_frame.map_or(f64::NAN, |bytes| bytes / 1024.0)
}

fn warm_kib(run: &RunSummary, cause: &str) -> f64 {
    run.warm_bytes_a_frame.as_ref().map_or(f64::NAN, |bytes| bytes.kib(cause))
}
