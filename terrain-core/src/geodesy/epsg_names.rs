use glam::DVec2;

/// Names of the systems most rasters come in; see [`epsg_name`].
const COMMON: &[(u32, &str)] = &[
    (2056, "CH1903+ / LV95"),
    (2154, "RGF93 v1 / Lambert-93"),
    (2193, "NZGD2000 / New Zealand Transverse Mercator 2000"),
    (3031, "WGS 84 / Antarctic Polar Stereographic"),
    (3034, "ETRS89-extended / LCC Europe"),
    (3035, "ETRS89-extended / LAEA Europe"),
    (3395, "WGS 84 / World Mercator"),
    (3413, "WGS 84 / NSIDC Sea Ice Polar Stereographic North"),
    (3857, "WGS 84 / Pseudo-Mercator"),
    (4087, "WGS 84 / World Equidistant Cylindrical"),
    (4258, "ETRS89"),
    (4269, "NAD83"),
    (4326, "WGS 84"),
    (5070, "NAD83 / Conus Albers"),
    (6933, "WGS 84 / NSIDC EASE-Grid 2.0 Global"),
    (27700, "OSGB36 / British National Grid"),
    (32662, "WGS 84 / Plate Carree"),
];

/// A name for people: the registered one for common systems, else `EPSG:<code>`.
pub fn epsg_name(epsg: u32) -> String {
    let zoned = |name: &str, zone: u32, side: &str| format!("{name} / UTM zone {zone}{side}");
    match epsg {
        32601..=32660 => zoned("WGS 84", epsg - 32600, "N"),
        32701..=32760 => zoned("WGS 84", epsg - 32700, "S"),
        25828..=25838 => zoned("ETRS89", epsg - 25800, "N"),
        26901..=26923 => zoned("NAD83", epsg - 26900, "N"),
        _ => COMMON
            .iter()
            .find(|(code, _)| *code == epsg)
            .map_or_else(|| format!("EPSG:{epsg}"), |(_, name)| (*name).to_owned()),
    }
}

/// The EPSG code of the WGS 84 UTM zone a place lies in. The widened zones of south-west Norway and
/// Svalbard are left out: a plain zone is as true to scale there.
pub fn utm_epsg(longitude_latitude_deg: DVec2) -> u32 {
    let turns = (longitude_latitude_deg.x + 180.0).rem_euclid(360.0) / 6.0;
    let zone = (turns.floor() as u32).min(59) + 1;
    if longitude_latitude_deg.y < 0.0 { 32700 + zone } else { 32600 + zone }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;

    #[test]
    fn utm_zones_of_known_places() {
        assert_eq!(utm_epsg(dvec2(8.3, 61.5)), 32632);
        assert_eq!(utm_epsg(dvec2(-121.5, 46.5)), 32610);
        assert_eq!(utm_epsg(dvec2(172.6, -43.5)), 32759);
        assert_eq!(utm_epsg(dvec2(180.0, 0.0)), 32601);
        assert_eq!(utm_epsg(dvec2(-180.0, 0.0)), 32601);
        assert_eq!(epsg_name(32632), "WGS 84 / UTM zone 32N");
        assert_eq!(epsg_name(1234), "EPSG:1234");
    }
}
