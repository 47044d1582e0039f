//! Tables as text and as HTML, from one value.

use std::fmt::{self, Write};

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    name: String,
    numeric: bool,
}

impl Column {
    /// A column of text: aligned to the left.
    #[must_use]
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), numeric: false }
    }

    /// A column of numbers: aligned to the right.
    #[must_use]
    pub fn number(name: impl Into<String>) -> Self {
        Self { name: name.into(), numeric: true }
    }
}

/// A table. Its display form is aligned text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(columns: impl IntoIterator<Item = Column>) -> Self {
        Self { columns: columns.into_iter().collect(), rows: Vec::new() }
    }

    /// Adds a row: a cell a column.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let cells: Vec<String> = cells.into_iter().collect();
        debug_assert_eq!(cells.len(), self.columns.len(), "a cell a column");
        self.rows.push(cells);
    }

    /// Whether it has no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The same without the columns that have no value in any row, which a dash stands for.
    #[must_use]
    pub fn without_blank_columns(self) -> Self {
        let is_blank =
            |place: &usize| !self.rows.is_empty() && self.rows.iter().all(|row| row[*place] == "–");
        let kept: Vec<usize> = (0..self.columns.len()).filter(|place| !is_blank(place)).collect();
        let of = |cells: &[String]| kept.iter().map(|&place| cells[place].clone()).collect();
        Self {
            columns: kept.iter().map(|&place| self.columns[place].clone()).collect(),
            rows: self.rows.iter().map(|row| of(row)).collect(),
        }
    }

    /// The table as an HTML element with its caption.
    #[must_use]
    pub fn to_html(&self, caption: &str) -> String {
        let mut html = format!("<table>\n<caption>{}</caption>\n<thead><tr>", escaped(caption));
        let class = |column: &Column| if column.numeric { " class=\"number\"" } else { "" };
        for column in &self.columns {
            let _ = write!(html, "<th scope=\"col\"{}>{}</th>", class(column), escaped(&column.name));
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            html.push_str("<tr>");
            for (place, (cell, column)) in row.iter().zip(&self.columns).enumerate() {
                // The first cell names the row.
                let (tag, scope) = if place == 0 { ("th", " scope=\"row\"") } else { ("td", "") };
                let _ = write!(html, "<{tag}{scope}{}>{}</{tag}>", class(column), escaped(cell));
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</tbody>\n</table>\n");
        html
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header: Vec<_> = self.columns.iter().map(|column| column.name.clone()).collect();
        let lines = || std::iter::once(&header).chain(&self.rows);
        let width = |place: usize| lines().map(|line| line[place].chars().count()).max().unwrap_or(0);
        let widths: Vec<_> = (0..self.columns.len()).map(width).collect();
        let lines: Vec<_> = lines().map(|line| aligned(&self.columns, &widths, line)).collect();
        f.write_str(&lines.join("\n"))
    }
}

/// A line of a table whose columns have these widths.
#[must_use]
pub fn aligned(columns: &[Column], widths: &[usize], cells: &[String]) -> String {
    let mut line = String::new();
    for ((column, &width), cell) in columns.iter().zip(widths).zip(cells) {
        let _ = match column.numeric {
            true => write!(line, "{cell:>width$}  "),
            false => write!(line, "{cell:<width$}  "),
        };
    }
    line.trim_end().to_owned()
}

/// Text as it stands in HTML.
#[must_use]
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new([Column::text("scene"), Column::number("µs")]);
        table.row(["a<b".to_owned(), "7".to_owned()]);
        table.row(["c".to_owned(), "123".to_owned()]);
        table
    }

    #[test]
    fn text_is_aligned() {
        assert_eq!(table().to_string(), "scene   µs\na<b      7\nc      123");
    }

    #[test]
    fn columns_without_values_can_go() {
        let mut table = Table::new(["row", "paper", "ours"].map(Column::text));
        table.row(["a", "–", "1"].map(str::to_owned));
        table.row(["b", "–", "–"].map(str::to_owned));
        assert_eq!(table.without_blank_columns().to_string(), "row  ours\na    1\nb    –");
    }

    #[test]
    fn html_is_escaped() {
        let html = table().to_html("x & y");
        assert!(html.contains("<caption>x &amp; y</caption>"));
        assert!(html.contains("<th scope=\"row\">a&lt;b</th><td class=\"number\">7</td>"));
    }
}
