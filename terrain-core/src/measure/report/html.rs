use std::fmt::Write;

use super::base64::base64;

/// A picture of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportPicture {
    /// A whole PNG file.
    pub png: Vec<u8>,
    /// What it shows.
    pub caption: String,
}

/// A page that holds everything it shows: one file to keep, send or print.
///
/// ```
/// use terrain_core::measure::report::HtmlReport;
///
/// let mut report = HtmlReport::new("A flight");
/// report
///     .heading("Bytes")
///     .paragraph("What went to the GPU.")
///     .table(&["cause", "MB"], &[["heights", "1.25"], ["imagery", "8.50"]]);
/// assert!(report.to_html().starts_with("<!DOCTYPE html>"));
/// ```
#[derive(Clone, Debug)]
pub struct HtmlReport {
    title: String,
    body: String,
}

impl HtmlReport {
    /// A page with nothing but this title.
    pub fn new(title: &str) -> Self {
        Self { title: escaped(title), body: String::new() }
    }

    /// Begins a section.
    pub fn heading(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<h2>{}</h2>", escaped(text)))
    }

    /// Begins a part of a section.
    pub fn subheading(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<h3>{}</h3>", escaped(text)))
    }

    /// Adds plain text.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<p>{}</p>", escaped(text)))
    }

    /// Adds a table. Columns of numbers stand right-aligned.
    pub fn table<H: AsRef<str>, Row: AsRef<[C]>, C: AsRef<str>>(
        &mut self,
        header: &[H],
        rows: &[Row],
    ) -> &mut Self {
        let is_number = |column: usize| {
            rows.iter()
                .filter_map(|row| row.as_ref().get(column))
                .all(|cell| is_number(cell.as_ref()))
        };
        let classes = (0..header.len())
            .map(|column| if is_number(column) { " class=\"number\"" } else { "" })
            .collect::<Vec<_>>();
        let class = |column: usize| classes.get(column).copied().unwrap_or("");
        let mut table = String::from("<div class=\"wide\"><table>\n<thead><tr>");
        for (column, cell) in header.iter().enumerate() {
            let _ = write!(table, "<th{}>{}</th>", class(column), escaped(cell.as_ref()));
        }
        table.push_str("</tr></thead>\n<tbody>\n");
        for row in rows {
            table.push_str("<tr>");
            for (column, cell) in row.as_ref().iter().enumerate() {
                let _ = write!(table, "<td{}>{}</td>", class(column), escaped(cell.as_ref()));
            }
            table.push_str("</tr>\n");
        }
        table.push_str("</tbody></table></div>");
        self.push(&table)
    }

    /// Adds a drawing: an SVG document as [`Plot::to_svg`](super::Plot::to_svg) makes it.
    pub fn figure(&mut self, svg: &str, caption: &str) -> &mut Self {
        let caption = figure_caption(caption);
        self.push(&format!("<figure>{svg}{caption}</figure>"))
    }

    /// Adds a picture, given as a whole PNG file.
    pub fn picture(&mut self, png: &[u8], caption: &str) -> &mut Self {
        let figure = picture_figure(png, caption);
        self.push(&figure)
    }

    /// Adds pictures side by side.
    pub fn pictures(&mut self, row: &[ReportPicture]) -> &mut Self {
        let figures = row.iter().map(|p| picture_figure(&p.png, &p.caption)).collect::<String>();
        self.push(&format!("<div class=\"row\">{figures}</div>"))
    }

    /// The page: UTF-8, no reference to anything outside itself.
    pub fn to_html(&self) -> String {
        let Self { title, body } = self;
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
             <h1>{title}</h1>\n{body}</main>\n</body>\n</html>\n"
        )
    }

    fn push(&mut self, element: &str) -> &mut Self {
        self.body.push_str(element);
        self.body.push('\n');
        self
    }
}

const STYLE: &str = include_str!("report.css");

fn picture_figure(png: &[u8], caption: &str) -> String {
    let (alt, data) = (escaped(caption), base64(png));
    let caption = figure_caption(caption);
    format!("<figure><img alt=\"{alt}\" src=\"data:image/png;base64,{data}\">{caption}</figure>")
}

fn figure_caption(text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    format!("<figcaption>{}</figcaption>", escaped(text))
}

/// Whether a cell holds a number, with or without a unit, or nothing.
fn is_number(cell: &str) -> bool {
    let first =
        cell.trim_start_matches(['-', '+', '\u{2212}', '<', '>', '≈', '≤', ' ']).chars().next();
    first.is_none_or(|c| c.is_ascii_digit() || matches!(c, '∞' | '–' | '.'))
}

fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            _ => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_the_page() {
        let mut report = HtmlReport::new("<script>");
        report.heading("a & b").paragraph("\"quoted\"").table(&["<td>"], &[["</table>"]]);
        let html = report.to_html();
        assert!(!html.contains("<script>") && html.contains("&lt;script&gt;"));
        assert!(html.contains("a &amp; b") && html.contains("&quot;quoted&quot;"));
        assert!(html.contains("&lt;/table&gt;"));
    }

    #[test]
    fn only_columns_of_numbers_stand_to_the_right() {
        let mut report = HtmlReport::new("");
        report.table(&["name", "value"], &[["3D", "−1.5 ms"], ["plain", ""], ["x", "∞"]]);
        let html = report.to_html();
        assert!(html.contains("<th>name</th><th class=\"number\">value</th>"), "{html}");
        assert!(html.contains("<td>3D</td><td class=\"number\">−1.5 ms</td>"), "{html}");
    }

    #[test]
    fn nothing_is_fetched_from_elsewhere() {
        let mut report = HtmlReport::new("all in one");
        report
            .picture(b"foobar", "a picture")
            .pictures(&[ReportPicture { png: b"foo".to_vec(), caption: String::new() }]);
        let html = report.to_html();
        assert!(html.contains("src=\"data:image/png;base64,Zm9vYmFy\""));
        for outside in ["http:", "https:", "@import", "url(", "<script", "<link"] {
            assert!(!html.contains(outside), "{outside}");
        }
    }
}
