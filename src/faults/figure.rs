//! The matrix as a figure: a panel for each stream, a square for each cell.

use super::matrix::{Matrix, StreamMatrix};
use std::fmt::Write;
use struna_harness::monitor::{Detector, Observability};

const CELL_PX: usize = 34;
const ROW_PX: usize = 19;
const LABEL_PX: usize = 190;
const HEAD_PX: usize = 92;
const PANEL_PX: usize = LABEL_PX + Detector::ALL.len() * CELL_PX + 24;

/// Draws `matrix` as SVG text: the darker, the larger the recall; hatched where nothing can be
/// seen.
#[must_use]
pub fn svg(matrix: &Matrix, title: &str) -> String {
    let rows = matrix.streams.iter().map(|stream| stream.rows.len()).max().unwrap_or(0);
    let (width, height) = (PANEL_PX * matrix.streams.len() + 20, HEAD_PX + ROW_PX * rows + 40);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    text(&mut out, 16, 26, "start", 18, title);
    for (k, stream) in matrix.streams.iter().enumerate() {
        panel(&mut out, stream, 10 + k * PANEL_PX);
    }
    let legend = "share of events found, in hundredths; grey label: not observable with one gyro";
    text(&mut out, 16, height - 14, "start", 12, legend);
    out.push_str("</svg>\n");
    out
}

fn panel(out: &mut String, stream: &StreamMatrix, left: usize) {
    text(out, left + 6, 50, "start", 14, stream.stream.name());
    for (k, detector) in Detector::ALL.into_iter().enumerate() {
        let x = left + LABEL_PX + k * CELL_PX + CELL_PX / 2;
        text(out, x, HEAD_PX - 8 - 14 * (k % 2), "middle", 11, detector.name());
    }
    for (k, row) in stream.rows.iter().enumerate() {
        let y = HEAD_PX + k * ROW_PX;
        let label = format!("{} {}", row.case.kind.name(), row.case.size);
        let seen = row.observability == Observability::Observable;
        let fill = if seen { "#000000" } else { "#999999" };
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{fill}\">{}</text>",
            left + LABEL_PX - 6,
            y + 14,
            escaped(label.trim_end()),
        );
        for (column, detector) in Detector::ALL.into_iter().enumerate() {
            square(out, (left + LABEL_PX + column * CELL_PX, y), row.recall(detector));
        }
    }
}

/// From white to blue, with the hundredths in it.
fn square(out: &mut String, (x, y): (usize, usize), recall: f64) {
    let shade = |end: f64| (255.0 + (end - 255.0) * recall).round();
    let (red, green, blue) = (shade(0.0), shade(80.0), shade(140.0));
    let _ = writeln!(
        out,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" fill=\"rgb({red},{green},{blue})\" \
         stroke=\"#dddddd\"/>",
        CELL_PX - 1,
        ROW_PX - 1,
    );
    if recall >= 0.005 {
        let fill = if recall > 0.5 { "#ffffff" } else { "#000000" };
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\" fill=\"{fill}\">\
             {:.0}</text>",
            x + CELL_PX / 2,
            y + 13,
            recall * 100.0,
        );
    }
}

fn text(out: &mut String, x: usize, y: usize, anchor: &str, size: usize, words: &str) {
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-size=\"{size}\">{}</text>",
        escaped(words),
    );
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;")
}
