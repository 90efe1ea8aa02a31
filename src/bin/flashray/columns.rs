//! Tables as text: rows of JSON, columns that know where in them they are.
use serde_json::Value;

/// A column: what it has in common with its neighbours, heading, decimals, factor and place in a row's JSON.
pub struct Column(pub &'static str, pub &'static str, pub usize, pub f64, pub &'static str);

/// Neighbours with something in common.
pub fn groups(columns: &[Column]) -> impl Iterator<Item = &[Column]> {
    columns.chunk_by(|a, b| a.0 == b.0)
}

impl Column {
    /// The cell of a row.
    pub fn cell(&self, row: &Value) -> String {
        let Self(_, _, decimals, factor, at) = *self;
        let number = row.pointer(at).and_then(Value::as_f64);
        number.map_or_else(|| "-".into(), |x| format!("{:.decimals$}", x * factor))
    }
}

/// Labels under their heading, and beside them the columns.
pub fn aligned(heading: &str, labels: &[String], rows: &[Value], columns: &[Column]) -> String {
    let first = labels.iter().map(String::len).fold(heading.len(), usize::max);
    let mut lines = vec![" ".repeat(first), format!("{heading:first$}")];
    lines.extend(labels.iter().map(|label| format!("{label:first$}")));
    for group in groups(columns) {
        lines.iter_mut().zip(block(rows, group)).for_each(|(line, part)| *line += &part);
    }
    lines.join("\n")
}

/// Columns as wide as their widest cell, numbers to the right; above them what they have in common.
fn block(rows: &[Value], group: &[Column]) -> Vec<String> {
    let mut lines = vec![String::new(); rows.len() + 1];
    for column in group {
        let cells = std::iter::once(column.1.to_owned()).chain(rows.iter().map(|row| column.cell(row)));
        let cells: Vec<String> = cells.collect();
        let width = cells.iter().map(String::len).max().unwrap_or(0) + 2;
        lines.iter_mut().zip(cells).for_each(|(line, cell)| line.extend([" ".repeat(width - cell.len()), cell]));
    }
    let name = [" ", group[0].0, " "].concat();
    let width = lines[0].len().max(name.len() + 4);
    let above = format!("  {name:-^0$}", width - 2);
    std::iter::once(above).chain(lines.iter().map(|line| format!("{line:>width$}"))).collect()
}

/// Text in lines of at most `width`.
pub fn wrapped(text: &str, width: usize) -> String {
    let (mut all, mut line) = (String::new(), 0);
    for word in text.split_whitespace() {
        if line > 0 && line + 1 + word.len() > width {
            all.push('\n');
            line = 0;
        } else if line > 0 {
            all.push(' ');
            line += 1;
        }
        all += word;
        line += word.len();
    }
    all
}
