//! The table of results.

/// One comparison.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) what: String,
    pub(crate) ours: String,
    /// The peer or the stated limit, with its name.
    pub(crate) other: String,
    /// How many times better than the other side we are; none when there is no other side.
    pub(crate) ratio: Option<f64>,
    /// Smallest ratio that meets the target.
    pub(crate) target: f64,
}

const HEADINGS: [&str; 6] = ["what", "ours", "peer or limit", "ratio", "target", "verdict"];

impl Row {
    fn cells(&self) -> [String; 6] {
        let ratio = self.ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
        let verdict = match self.ratio {
            None => "no peer",
            Some(ratio) if ratio >= self.target => "met",
            Some(_) => "not met",
        };
        let target = format!(">= {:.2}", self.target);
        [&self.what, &self.ours, &self.other, &ratio, &target, verdict].map(str::to_owned)
    }
}

/// The rows as text, in columns.
pub(crate) fn render(rows: &[Row]) -> String {
    let lines: Vec<_> =
        std::iter::once(HEADINGS.map(str::to_owned)).chain(rows.iter().map(Row::cells)).collect();
    let mut widths = [0; HEADINGS.len()];
    for line in &lines {
        for (width, cell) in widths.iter_mut().zip(line) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let padded = |line: &[String; 6]| {
        let cells = line.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let mut text: Vec<_> = lines.iter().map(padded).collect();
    text.insert(1, widths.map(|width| "-".repeat(width)).join("  "));
    text.push(
        "\nratio: how many times better than the peer or limit; best bursts of one run".into(),
    );
    text.join("\n")
}

/// Nanoseconds, from seconds.
pub(crate) fn ns(seconds: f64) -> String {
    format!("{:.1} ns", seconds * 1e9)
}
