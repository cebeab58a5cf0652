//! One picture of a run: rates above, angles below; signals left, errors right. Reads the record
//! and nothing else.

use crate::record::{Record, TRUE_BODY_RATE, TRUE_TWIST_RATE};
use plotters::coord::Shift;
use plotters::prelude::{
    ChartBuilder, DrawingArea, DrawingAreaErrorKind, DrawingBackend, IntoDrawingArea, LineSeries,
    PathElement, RGBColor, SVGBackend, Text, WHITE,
};
use plotters::style::{Color, ShapeStyle};
use std::borrow::Cow;
use std::ops::Range;
use struna_kernel::{RAD_PER_DEG, RateOf};

pub(crate) const SIZE_PX: (u32, u32) = (1400, 900);
/// Height of title and legend together.
pub(crate) const HEAD_PX: u32 = 74;
/// Least distance from one entry of the legend to the next.
const LEGEND_STEP_PX: i32 = 150;
/// Line of an entry with what is left free about it, and a letter.
const LEGEND_LINE_PX: i32 = 66;
const LETTER_PX: i32 = 8;
pub(crate) const FONT: &str = "sans-serif";
/// Horizontal resolution of a curve; each step keeps its least and greatest value.
const BUCKETS: usize = 700;
const GREY: RGBColor = RGBColor(185, 185, 185);
const BLACK: RGBColor = RGBColor(0, 0, 0);
const SLATE: RGBColor = RGBColor(110, 110, 110);
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

/// One curve, in the SI unit of its record column.
pub(crate) struct Curve<'a> {
    pub(crate) values: Cow<'a, [f64]>,
    pub(crate) style: ShapeStyle,
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
        let (head, body) = root.split_vertically(HEAD_PX);
        head.draw(&Text::new(title.to_owned(), (24, 12), (FONT, 24)))?;
        legend(&head, record)?;
        let panels = body.split_evenly((2, 2));
        let time_s = record.column("time").unwrap_or_default();
        let truth = angle_truth(record);
        panel(&panels[0], "rate, deg/s", time_s, &rates(record))?;
        panel(&panels[1], rate_error_label(record), time_s, &rate_errors(record))?;
        panel(&panels[2], "angle, deg", time_s, &angles(record, truth))?;
        panel(&panels[3], "angle error, deg", time_s, &angle_errors(record, truth))?;
        root.present()?;
    }
    Ok(text)
}

/// The angle that estimates are drawn against: the twist, or what a recording has in its place.
fn angle_truth(record: &Record) -> &'static str {
    let twist = "truth.twist_rad";
    if record.column(twist).is_some() { twist } else { "truth.body_rate_integral_rad" }
}

pub(crate) fn gyro_style() -> ShapeStyle {
    GREY.stroke_width(1)
}

pub(crate) fn truth_style() -> ShapeStyle {
    BLACK.stroke_width(4)
}

pub(crate) fn estimator_style(k: usize) -> ShapeStyle {
    PALETTE[k % PALETTE.len()].stroke_width(2)
}

fn twist_style() -> ShapeStyle {
    SLATE.stroke_width(4)
}

/// Whether the rate of the estimator called `name` is drawn against that of the twist.
fn tells_twist(record: &Record, name: &str) -> bool {
    let truth = record.rate_of(name).and_then(|of| record.true_rate(of));
    matches!(truth, Some((RateOf::Twist, _)))
}

/// Whether one of them is, so that there are two true rates in the picture.
fn has_two_rates(record: &Record) -> bool {
    record.estimators().any(|name| tells_twist(record, name))
}

fn rate_error_label(record: &Record) -> &'static str {
    if has_two_rates(record) {
        "error of the rate that each tells, deg/s"
    } else {
        "rate error, deg/s"
    }
}

fn rates(record: &Record) -> Vec<Curve<'_>> {
    let gyro = signal(record, "measured_rate_rad_s", gyro_style());
    let body = signal(record, TRUE_BODY_RATE, truth_style());
    let twist = has_two_rates(record).then(|| signal(record, TRUE_TWIST_RATE, twist_style()));
    let truth = body.into_iter().chain(twist.flatten());
    let estimates = of_estimators(record, "rate_rad_s").map(|(_, curve)| curve);
    gyro.into_iter().chain(truth).chain(estimates).collect()
}

fn angles<'a>(record: &'a Record, truth: &str) -> Vec<Curve<'a>> {
    let truth = signal(record, truth, truth_style());
    truth.into_iter().chain(of_estimators(record, "angle_rad").map(|(_, curve)| curve)).collect()
}

fn rate_errors(record: &Record) -> Vec<Curve<'_>> {
    let gyro = signal(record, "measured_rate_rad_s", gyro_style());
    let gyro = gyro.map(|curve| less(curve, record.column(TRUE_BODY_RATE)));
    let estimates = of_estimators(record, "rate_rad_s").filter_map(|(name, curve)| {
        let (_, truth) = record.true_rate(record.rate_of(name)?)?;
        Some(less(curve, Some(truth)))
    });
    gyro.into_iter().chain(estimates).collect()
}

fn angle_errors<'a>(record: &'a Record, truth: &str) -> Vec<Curve<'a>> {
    let truth = record.column(truth);
    of_estimators(record, "angle_rad").map(|(_, curve)| less(curve, truth)).collect()
}

fn signal<'a>(record: &'a Record, column: &str, style: ShapeStyle) -> Option<Curve<'a>> {
    Some(Curve { values: Cow::Borrowed(record.column(column)?), style })
}

/// One quantity of each estimator that has it. Plain integration has no rate of its own, only the
/// gyro's, which is drawn already.
fn of_estimators<'a>(
    record: &'a Record,
    quantity: &str,
) -> impl Iterator<Item = (&'a str, Curve<'a>)> {
    let is_rate = quantity == "rate_rad_s";
    record.estimators().enumerate().filter_map(move |(k, name)| {
        let column = format!("{name}.{quantity}");
        let curve = signal(record, &column, estimator_style(k))?;
        let is_gyro = record.column("measured_rate_rad_s") == record.column(&column);
        (!(is_rate && is_gyro)).then_some((name, curve))
    })
}

/// The curve less the truth; without one, nothing.
fn less<'a>(curve: Curve<'a>, truth: Option<&[f64]>) -> Curve<'a> {
    let truth = truth.unwrap_or_default();
    let errors = curve.values.iter().zip(truth).map(|(value, truth)| value - truth).collect();
    Curve { values: Cow::Owned(errors), style: curve.style }
}

/// One legend for all panels, beside nothing that could be hidden by it.
fn legend<B>(head: &DrawingArea<B, Shift>, record: &Record) -> Result<(), FigureError>
where
    B: DrawingBackend,
    B::ErrorType: std::error::Error + Send + Sync + 'static,
{
    let mut x = 28;
    for (label, style) in entries(record) {
        let letters = i32::try_from(label.chars().count()).unwrap_or(i32::MAX);
        head.draw(&PathElement::new([(x, 56), (x + 30, 56)], style))?;
        head.draw(&Text::new(label, (x + 38, 48), (FONT, 16)))?;
        let step_px = letters.saturating_mul(LETTER_PX).saturating_add(LEGEND_LINE_PX);
        x = x.saturating_add(step_px.max(LEGEND_STEP_PX));
    }
    Ok(())
}

/// What stands in the legend. Where there are two true rates, each estimator's says which is its.
fn entries(record: &Record) -> Vec<(String, ShapeStyle)> {
    let is_two = has_two_rates(record);
    let mut all = vec![("gyro".to_owned(), gyro_style())];
    if is_two {
        all.push(("truth (rate: body axis)".to_owned(), truth_style()));
        all.push(("true rate of twist".to_owned(), twist_style()));
    } else {
        all.push(("truth".to_owned(), truth_style()));
    }
    all.extend(record.estimators().enumerate().map(|(k, name)| {
        let rate_of = record.rate_of(name).map_or("unknown", RateOf::words);
        let label = if is_two { format!("{name} (rate: {rate_of})") } else { name.to_owned() };
        (label, estimator_style(k))
    }));
    all
}

pub(crate) fn panel<B>(
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
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(74)
        .build_cartesian_2d(0.0..end_s, y_range(curves))?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("time, s")
        .y_desc(y_label)
        .x_label_formatter(&|value| tick(*value))
        .y_label_formatter(&|value| tick(*value))
        .label_style((FONT, 15))
        .axis_desc_style((FONT, 17))
        .draw()?;
    for curve in curves {
        chart.draw_series(LineSeries::new(thinned(time_s, &curve.values), curve.style))?;
    }
    Ok(())
}

/// A tick label without the digits that only rounding has put there.
fn tick(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The range of all finite values with a margin, in degrees.
fn y_range(curves: &[Curve<'_>]) -> Range<f64> {
    let values = curves.iter().flat_map(|c| c.values.iter()).copied();
    let (least, greatest) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
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
    fn tick_labels_carry_no_rounding_dust() {
        assert_eq!(tick(0.1 + 0.2), "0.3");
        assert_eq!(tick(450.0), "450");
        assert_eq!(tick(-1e-9), "0");
    }

    /// A record of two estimators, one of each rate.
    fn two_rates(has_twist: bool) -> Record {
        let twist = has_twist.then_some(TRUE_TWIST_RATE);
        let of = ["a.angle_rad", "a.rate_rad_s", "a.rate_of"];
        let more = ["b.angle_rad", "b.rate_rad_s", "b.rate_of"];
        let names = ["time", TRUE_BODY_RATE].into_iter().chain(twist).chain(of).chain(more);
        let mut record = Record::with_columns(names.map(str::to_owned));
        let twist = has_twist.then_some(3.0);
        let row = [0.0, 1.0].into_iter().chain(twist).chain([0.0, 4.0, 0.0, 0.0, 4.0, 1.0]);
        record.push(&row.collect::<Vec<_>>());
        record
    }

    #[test]
    fn errors_of_rates_are_drawn_against_the_rate_told_and_the_legend_says_so() {
        let errors = |record: &Record| -> Vec<f64> {
            rate_errors(record).iter().map(|curve| curve.values[0]).collect()
        };
        let record = two_rates(true);
        assert_eq!(errors(&record), [3.0, 1.0]);
        let text = svg(&record, "two").unwrap();
        for words in ["true rate of twist", "a (rate: body axis)", "b (rate: twist)", "each tells"]
        {
            assert!(text.contains(words), "{words}");
        }
        // A recording has one true rate, and nothing needs to be told apart.
        let record = two_rates(false);
        assert_eq!(errors(&record), [3.0, 3.0]);
        let text = svg(&record, "one").unwrap();
        assert!(!text.contains("twist") && text.contains("rate error, deg/s"));
    }

    #[test]
    fn a_record_without_rows_still_draws() {
        let names = ["time", "measured_rate_rad_s", "a.angle_rad"].map(str::to_owned);
        let text = svg(&Record::with_columns(names), "empty").unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
    }
}
