//! One picture of a run: rates above, angles below. Reads the record and nothing else.

use crate::record::Record;
use plotters::coord::Shift;
use plotters::prelude::{
    ChartBuilder, DrawingArea, DrawingAreaErrorKind, DrawingBackend, IntoDrawingArea, LineSeries,
    PathElement, RGBColor, SVGBackend, SeriesLabelPosition, WHITE,
};
use plotters::style::{Color, IntoFont, ShapeStyle};
use std::ops::Range;
use struna_kernel::RAD_PER_DEG;

const SIZE_PX: (u32, u32) = (1200, 900);
/// Horizontal resolution of a curve; each step keeps its least and greatest value.
const BUCKETS: usize = 900;
const GREY: RGBColor = RGBColor(190, 190, 190);
const BLACK: RGBColor = RGBColor(0, 0, 0);
/// Colours that stay apart for colour-blind readers (Okabe and Ito, 2008).
const PALETTE: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// A figure that could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the figure: {reason}")]
pub struct FigureError {
    /// What the plotting library said.
    pub reason: String,
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for FigureError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self { reason: error.to_string() }
    }
}

/// One curve of a panel.
struct Curve<'a> {
    label: String,
    values_rad: &'a [f64],
    style: ShapeStyle,
}

/// Draws `record` as SVG text.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn svg(record: &Record, title: &str) -> Result<String, FigureError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE_PX).into_drawing_area();
        root.fill(&WHITE)?;
        let root = root.titled(title, ("sans-serif", 24))?;
        let (upper, lower) = root.split_vertically(root.dim_in_pixel().1 / 2);
        let time_s = record.column("time").unwrap_or_default();
        panel(&upper, "rate, deg/s", time_s, &rate_curves(record))?;
        panel(&lower, "angle, deg", time_s, &angle_curves(record))?;
        root.present()?;
    }
    Ok(text)
}

fn rate_curves(record: &Record) -> Vec<Curve<'_>> {
    let mut curves = Vec::new();
    let mut add = |label: &str, column: &str, style: ShapeStyle| {
        if let Some(values_rad) = record.column(column) {
            curves.push(Curve { label: label.to_owned(), values_rad, style });
        }
    };
    add("gyro", "measured_rate_rad_s", GREY.stroke_width(1));
    add("truth", "truth.body_rate_rad_s", BLACK.stroke_width(3));
    // Plain integration has no rate of its own: its rate is the gyro's, drawn already.
    for (k, name) in record.estimators().enumerate().filter(|(_, name)| *name != "integration") {
        add(name, &format!("{name}.rate_rad_s"), colour(k).stroke_width(1));
    }
    curves
}

fn angle_curves(record: &Record) -> Vec<Curve<'_>> {
    let mut curves = Vec::new();
    let mut add = |label: &str, column: &str, style: ShapeStyle| {
        if let Some(values_rad) = record.column(column) {
            curves.push(Curve { label: label.to_owned(), values_rad, style });
        }
    };
    if record.column("truth.twist_rad").is_some() {
        add("truth: twist", "truth.twist_rad", BLACK.stroke_width(4));
    } else {
        add("integral of the true rate", "truth.body_rate_integral_rad", BLACK.stroke_width(4));
    }
    for (k, name) in record.estimators().enumerate() {
        add(name, &format!("{name}.angle_rad"), colour(k).stroke_width(2));
    }
    curves
}

fn colour(k: usize) -> RGBColor {
    PALETTE[k % PALETTE.len()]
}

fn panel<B>(
    area: &DrawingArea<B, Shift>,
    y_label: &str,
    time_s: &[f64],
    curves: &[Curve<'_>],
) -> Result<(), FigureError>
where
    B: DrawingBackend,
    B::ErrorType: std::error::Error + Send + Sync + 'static,
{
    let end_s = time_s.last().copied().unwrap_or(1.0).max(1e-9);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..end_s, y_range(curves))?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("time, s")
        .y_desc(y_label)
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 17))
        .draw()?;
    for curve in curves {
        let style = curve.style;
        chart
            .draw_series(LineSeries::new(thinned(time_s, curve.values_rad), style))?
            .label(curve.label.clone())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(GREY)
        .label_font(("sans-serif", 15).into_font())
        .draw()?;
    Ok(())
}

/// The range of all finite values with a margin, in degrees.
fn y_range(curves: &[Curve<'_>]) -> Range<f64> {
    let finite = curves.iter().flat_map(|c| c.values_rad).copied().filter(|v| v.is_finite());
    let (least, greatest) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if least > greatest {
        return -1.0..1.0;
    }
    let (least, greatest) = (least / RAD_PER_DEG, greatest / RAD_PER_DEG);
    let margin = (0.05 * (greatest - least)).max(1e-6);
    least - margin..greatest + margin
}

/// The curve in degrees, thinned to the least and the greatest value of each bucket of time, in the
/// order in which they occur: noise keeps its width and a spike stays visible.
fn thinned(time_s: &[f64], values_rad: &[f64]) -> Vec<(f64, f64)> {
    let n = time_s.len().min(values_rad.len());
    let per_bucket = n.div_ceil(BUCKETS).max(1);
    let mut points = Vec::with_capacity(2 * BUCKETS);
    for start in (0..n).step_by(per_bucket) {
        let bucket = start..(start + per_bucket).min(n);
        let finite = || bucket.clone().filter(|k| values_rad[*k].is_finite());
        let by_value = |a: &usize, b: &usize| values_rad[*a].total_cmp(&values_rad[*b]);
        let (Some(low), Some(high)) = (finite().min_by(by_value), finite().max_by(by_value)) else {
            continue;
        };
        let mut ends = vec![low.min(high), low.max(high)];
        ends.dedup();
        points.extend(ends.into_iter().map(|k| (time_s[k], values_rad[k] / RAD_PER_DEG)));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_spikes_and_both_ends() {
        let time_s: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values = vec![0.0; 100_000];
        values[54_321] = RAD_PER_DEG;
        values[99_999] = -RAD_PER_DEG;
        let points = thinned(&time_s, &values);
        assert!(points.len() <= 2 * BUCKETS);
        assert!(points.contains(&(54_321.0, 1.0)));
        assert_eq!(points.last(), Some(&(99_999.0, -1.0)));
    }

    #[test]
    fn a_record_without_rows_still_draws() {
        let names = ["time", "measured_rate_rad_s", "a.angle_rad"].map(str::to_owned);
        let text = svg(&Record::with_columns(names), "empty").unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
    }
}
