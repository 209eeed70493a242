use terrain_core::measure::report::HtmlReport;

const COUNTED: [&str; 4] = [
    "Counted are the bytes that the program hands to the graphics API to be copied to the GPU, where it \
     does so: heights, imagery, tables, meshes, uniforms; those it maps and reads back; and those of \
     files or replies that it reads, as they are stored. Level 0, which is there before the first frame, \
     counts to the first frame.",
    "Not counted are the pictures themselves, commands, pipelines and shaders, and what is sent once when \
     a renderer opens and has nothing to do with the data.",
    "Heights cross in 16 bits where their tile's range allows and in 32 otherwise; imagery in the \
     dataset's own encoding where the GPU decodes it (BC7, BC1), as RGBA8 otherwise. The GPU makes coarser \
     mips of both itself.",
    "Errors are those of what is on the screen, against the exact picture of the same camera, which is \
     cast ray by ray against the finest samples.",
];

const MEANINGS: [&str; 5] = [
    "FLIP (0 to 1) is how different two pictures look when one flips between them; PSNR and SSIM are \
     the older measures of the same. Each is taken against the exact picture of the same camera.",
    "Height RMSE is over the pixels that show ground, each against the exact height at the place it \
     shows.",
    "Screen-space error is how many pixels lie between where a point of the ground is drawn and where \
     it truly projects to; silhouette error how many lie between drawn and true silhouettes.",
    "Swim is how many pixels a point of the ground moves by itself until the next frame while the \
     data stay; popping the FLIP error between a frame without and with the tiles that arrived in it.",
    "Jank-sum is the time by which frames exceed 16.7 ms, all together. A frame is late where a tile \
     that it wants is not there yet.",
];

/// What bytes and errors are, and what is left out.
pub fn add_counted(report: &mut HtmlReport) {
    add(report, "What is counted, and what is not", &COUNTED);
}

/// What the numbers of the tables mean.
pub fn add_meanings(report: &mut HtmlReport) {
    add(report, "What the numbers mean", &MEANINGS);
}

fn add(report: &mut HtmlReport, heading: &str, paragraphs: &[&str]) {
    report.heading(heading);
    for paragraph in paragraphs {
        report.paragraph(paragraph);
    }
}
