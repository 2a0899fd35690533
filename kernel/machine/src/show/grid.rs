//! Tables as text.

/// Rows of cells with a heading, left-aligned.
pub(super) struct TextTable(Vec<Vec<String>>);

impl TextTable {
    pub(super) fn new(heading: &[&str]) -> Self {
        Self(vec![heading.iter().map(|cell| (*cell).to_owned()).collect()])
    }

    pub(super) fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.0.push(cells.into());
    }

    /// Stacks grids with the same columns, and adds a first column with their names.
    pub(super) fn below<'n>(grids: impl Iterator<Item = (&'n str, TextTable)>, heading: &str) -> Self {
        let mut all: Vec<Vec<String>> = Vec::new();
        for (name, TextTable(rows)) in grids {
            let first = usize::from(!all.is_empty());
            for (at, mut row) in rows.into_iter().enumerate().skip(first) {
                row.insert(0, if at == 0 { heading } else { name }.to_owned());
                all.push(row);
            }
        }
        Self(all)
    }

    pub(super) fn text(&self) -> String {
        let columns = self.0.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.0.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = String::new();
        for row in &self.0 {
            let cells: Vec<String> =
                row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}", width = *width)).collect();
            text.push_str(cells.join("  ").trim_end());
            text.push('\n');
        }
        text
    }
}
