//! Names in the cells of a table.

/// A name as a cell of CSV: in quotes where it has to be, and with an apostrophe in front where a spreadsheet would take it for a formula
/// (OWASP, CSV injection).
pub(super) fn cell(name: &str) -> String {
    let prefix = if name.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    if name.contains([',', '"', '\n', '\r', '#']) {
        format!("\"{prefix}{}\"", name.replace('"', "\"\""))
    } else {
        format!("{prefix}{name}")
    }
}

#[cfg(test)]
mod tests {
    use super::cell;

    #[test]
    fn formulas_are_texts() {
        assert_eq!(cell("j1"), "j1");
        assert_eq!(cell("=cmd|' /C calc'!A0"), "'=cmd|' /C calc'!A0");
        assert_eq!(cell("-1,\"2\""), "\"'-1,\"\"2\"\"\"");
    }
}
