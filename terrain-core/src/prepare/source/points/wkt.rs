//! The EPSG code in well-known text (OGC 01-009, "Coordinate Transformation Services", 2001, and OGC 18-010r7, "Well-known Text
//! Representation of Coordinate Reference Systems", 2019).

/// Deepest nesting that is followed: that of real systems is below ten.
const DEEPEST: usize = 32;

/// A keyword with what stands in its brackets.
struct Node<'a> {
    keyword: &'a str,
    values: Vec<&'a str>,
    nodes: Vec<Node<'a>>,
}

/// The code of the text's projected or geographic system; that of a compound system's horizontal part.
/// `None` where the text names none.
pub fn epsg_of_wkt(text: &str) -> Option<u32> {
    let root = parse(&mut text.trim_matches(['\0', ' ', '\n', '\r', '\t']), 0)?;
    horizontal(&root)?.epsg()
}

fn horizontal<'a, 'b>(node: &'b Node<'a>) -> Option<&'b Node<'a>> {
    const HORIZONTAL: [&str; 8] = [
        "PROJCS",
        "GEOGCS",
        "PROJCRS",
        "PROJECTEDCRS",
        "GEOGCRS",
        "GEOGRAPHICCRS",
        "GEODCRS",
        "GEODETICCRS",
    ];
    const AROUND: [&str; 4] = ["COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS"];
    let is_one_of =
        |names: &[&str]| names.iter().any(|name| node.keyword.eq_ignore_ascii_case(name));
    if is_one_of(&HORIZONTAL) {
        return Some(node);
    }
    is_one_of(&AROUND).then(|| node.nodes.iter().find_map(horizontal)).flatten()
}

impl Node<'_> {
    fn epsg(&self) -> Option<u32> {
        let is_code = |node: &&Node<'_>| {
            matches!(node.keyword.to_ascii_uppercase().as_str(), "AUTHORITY" | "ID")
                && node.values.first().is_some_and(|name| name.eq_ignore_ascii_case("EPSG"))
        };
        self.nodes.iter().find(is_code)?.values.get(1)?.parse().ok()
    }
}

/// Takes a node from the beginning of the text.
fn parse<'a>(text: &mut &'a str, depth: usize) -> Option<Node<'a>> {
    let bracket = text.find(['[', '('])?;
    let keyword = text[..bracket].trim();
    *text = &text[bracket + 1..];
    let mut node = Node { keyword, values: Vec::new(), nodes: Vec::new() };
    loop {
        *text = text.trim_start();
        match text.chars().next()? {
            ']' | ')' => {
                *text = &text[1..];
                return Some(node);
            }
            ',' => *text = &text[1..],
            '"' => {
                let (value, rest) = text[1..].split_once('"')?;
                node.values.push(value);
                *text = rest;
            }
            _ => {
                let end = text.find([',', '[', '(', ']', ')'])?;
                match text.as_bytes()[end] {
                    b'[' | b'(' if depth < DEEPEST => node.nodes.push(parse(text, depth + 1)?),
                    b'[' | b'(' => return None,
                    _ => {
                        node.values.push(text[..end].trim());
                        *text = &text[end..];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_code_is_that_of_the_horizontal_system_itself() {
        let geographic = r#"GEOGCS["NZGD2000",DATUM["D",SPHEROID["GRS 1980",6378137,298.257222101,
            AUTHORITY["EPSG","7019"]],AUTHORITY["EPSG","6167"]],UNIT["degree",0.0174],AUTHORITY["EPSG","4167"]]"#;
        let projected = format!(
            r#"PROJCS["NZTM, \(2000\)",{geographic},PARAMETER["false_easting",1600000],AUTHORITY["EPSG","2193"]]"#
        );
        let compound = format!(
            r#"COMPD_CS["both",{projected},VERT_CS["h",AUTHORITY["EPSG","7839"]],AUTHORITY["EPSG","9999"]]"#
        );
        assert_eq!(epsg_of_wkt(geographic), Some(4167));
        assert_eq!(epsg_of_wkt(&projected), Some(2193));
        assert_eq!(epsg_of_wkt(&format!("{compound}\0\0")), Some(2193));
        let second = r#"COMPOUNDCRS["c", PROJCRS ["u", BASEGEOGCRS["w", ID["EPSG",4326]], ID["EPSG", 32632]], VERTCRS["v"]]"#;
        assert_eq!(epsg_of_wkt(second), Some(32632));
        assert_eq!(epsg_of_wkt(r#"PROJCS["own",GEOGCS["w",AUTHORITY["EPSG","4326"]]]"#), None);
    }

    #[test]
    fn damaged_text_has_no_code() {
        let deep = "PROJCS[".repeat(100_000);
        for text in ["", "]", "PROJCS", "PROJCS[", "PROJCS[\"a", "PROJCS[\"a\",é", &deep] {
            assert_eq!(epsg_of_wkt(text), None);
        }
    }
}
