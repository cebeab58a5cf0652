//! The Allan deviation as a picture: curve and interval, the slopes that explain it, and what of it
//! is not to be trusted.

mod axes;
mod side;

use super::Characterized;
use super::unit::DEG_H;
use crate::figure::FigureError;
use axes::{Axes, FRAME};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, IntoFont, PathElement, Polygon, RGBColor, Rectangle,
    SVGBackend, Text, TextStyle, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform};
use struna_gyro::characterise::{AllanPoint, MISFIT_REFUSED, NoiseModel, Term};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const SIZE_PX: (u32, u32) = (1240, 800);
const FONT: &str = "sans-serif";
const BLACK: RGBColor = RGBColor(25, 25, 25);
const TEXT: RGBColor = RGBColor(70, 70, 70);
const GRID: RGBColor = RGBColor(236, 236, 236);
const DECADE: RGBColor = RGBColor(212, 212, 212);
const SHADE: RGBColor = RGBColor(243, 243, 243);
const HATCH: RGBColor = RGBColor(218, 218, 218);
const FAINT: RGBColor = RGBColor(160, 160, 160);
/// Colours that stay apart for colour-blind readers (Okabe and Ito, 2008).
const CURVE: RGBColor = RGBColor(0, 114, 178);
const MODEL: RGBColor = RGBColor(213, 94, 0);
const BOUND: RGBColor = RGBColor(204, 121, 167);
/// Distance of hatching lines.
const HATCH_PX: i32 = 12;

/// Colour of a term.
fn colour(term: Term) -> RGBColor {
    match term {
        Term::Quantisation => RGBColor(204, 121, 167),
        Term::AngleRandomWalk => RGBColor(0, 158, 115),
        Term::BiasInstability => RGBColor(180, 122, 0),
        Term::RateRandomWalk => RGBColor(50, 140, 190),
        Term::RateRamp => RGBColor(120, 94, 160),
    }
}

/// Slope of a term in the deviation, as a number and as a label.
fn slope(term: Term) -> (f64, &'static str) {
    match term {
        Term::Quantisation => (-1.0, "-1"),
        Term::AngleRandomWalk => (-0.5, "-1/2"),
        Term::BiasInstability => (0.0, "0"),
        Term::RateRandomWalk => (0.5, "+1/2"),
        Term::RateRamp => (1.0, "+1"),
    }
}

/// Draws what was found as SVG text.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn svg(of: &Characterized) -> Result<String, FigureError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE_PX).into_drawing_area();
        root.fill(&WHITE)?;
        let points: Vec<AllanPoint> =
            of.found.points.iter().filter(|point| point.adev_rad_s > 0.0).copied().collect();
        let axes = axes_around(&points);
        shades(&root, &axes, of)?;
        grid(&root, &axes)?;
        band(&root, &axes, &points)?;
        // A fit that describes nothing would only mislead.
        if of.found.misfit <= MISFIT_REFUSED {
            slopes(&root, &axes, of)?;
            model_line(&root, &axes, of, &of.found.model, MODEL)?;
        }
        if let Some(bound) = &of.found.overbound {
            model_line(&root, &axes, of, bound, BOUND)?;
        }
        curves(&root, &axes, &points)?;
        frame(&root, &axes)?;
        side::draw(&root, of)?;
        root.present()?;
    }
    Ok(text)
}

/// Deviations in °/h over all points and the intervals of the trusted ones.
fn axes_around(points: &[AllanPoint]) -> Axes {
    let trusted = points.iter().filter(|point| point.trusted);
    let ends = trusted.flat_map(|point| point.interval_rad_s);
    let deviations = points.iter().map(|point| point.adev_rad_s).chain(ends);
    let over = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, 0.0_f64], |[a, b], v| [a.min(v), b.max(v)])
    };
    let deviations = over(&mut deviations.map(|rad_s| rad_s / DEG_H).filter(|v| v.is_finite()));
    Axes::around(over(&mut points.iter().map(|point| point.tau_s)), deviations)
}

/// Grey where there are few averages, hatched where the gyro's band hides its noise.
fn shades(root: &Area<'_>, axes: &Axes, of: &Characterized) -> Result<(), FigureError> {
    let [left, top, right, bottom] = FRAME;
    let points = &of.found.points;
    let between = |a: &AllanPoint, b: &AllanPoint| axes.x((a.tau_s * b.tau_s).sqrt());
    if let Some(pair) = points.windows(2).find(|pair| pair[0].filtered && !pair[1].filtered) {
        let edge = between(&pair[0], &pair[1]);
        hatch(root, left, edge)?;
        label(root, "hidden by the band", (left + 10, bottom - 26), 14, FAINT)?;
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[0].trusted && !pair[1].trusted) {
        let edge = between(&pair[0], &pair[1]);
        root.draw(&Rectangle::new([(edge, top), (right, bottom)], SHADE.filled()))?;
        let style = style(14, FAINT).pos(Pos::new(HPos::Right, VPos::Top));
        root.draw(&Text::new("few averages", (right - 8, top + 8), style))?;
    }
    Ok(())
}

fn hatch(root: &Area<'_>, left: i32, right: i32) -> Result<(), FigureError> {
    let [_, top, _, bottom] = FRAME;
    root.draw(&Rectangle::new([(left, top), (right, bottom)], SHADE.filled()))?;
    let (width, height) = (right - left, bottom - top);
    for start in (-height..width).step_by(HATCH_PX.unsigned_abs() as usize) {
        // Rising to the right by one pixel per pixel, from the bottom at `start`.
        let (from, to) = (start.max(0), (start + height).min(width));
        if from < to {
            let point = |along: i32| (left + along, bottom - (along - start));
            root.draw(&PathElement::new([point(from), point(to)], HATCH.stroke_width(1)))?;
        }
    }
    Ok(())
}

fn grid(root: &Area<'_>, axes: &Axes) -> Result<(), FigureError> {
    let [left, top, right, bottom] = FRAME;
    for decades in [false, true] {
        let style = if decades { DECADE } else { GRID }.stroke_width(1);
        for tick in axes.x_ticks().iter().filter(|tick| tick.is_decade == decades) {
            root.draw(&PathElement::new([(tick.at, top), (tick.at, bottom)], style))?;
        }
        for tick in axes.y_ticks().iter().filter(|tick| tick.is_decade == decades) {
            root.draw(&PathElement::new([(left, tick.at), (right, tick.at)], style))?;
        }
    }
    Ok(())
}

/// The confidence interval.
fn band(root: &Area<'_>, axes: &Axes, points: &[AllanPoint]) -> Result<(), FigureError> {
    let edge =
        |end: usize| points.iter().map(move |p| axes.at(p.tau_s, p.interval_rad_s[end] / DEG_H));
    let outline: Vec<_> = edge(1).chain(edge(0).rev()).collect();
    Ok(root.draw(&Polygon::new(outline, CURVE.mix(0.16).filled()))?)
}

/// The straight slopes of the model, each with its name where it matters most.
fn slopes(root: &Area<'_>, axes: &Axes, of: &Characterized) -> Result<(), FigureError> {
    let model = &of.found.model;
    let usable: Vec<f64> =
        of.found.points.iter().filter(|point| point.is_usable()).map(|p| p.tau_s).collect();
    for term in Term::ALL.into_iter().filter(|term| model.has(*term)) {
        let share = |tau_s: f64| model.share(term, tau_s) / model.variance(tau_s);
        let most = usable.iter().map(|tau_s| share(*tau_s)).fold(0.0, f64::max);
        // In the middle of where it matters.
        let ruled: Vec<f64> =
            usable.iter().copied().filter(|tau_s| share(*tau_s) >= 0.8 * most).collect();
        let Some(tau_s) = ruled.get(ruled.len() / 2).copied() else { continue };
        let deviation = model.share(term, tau_s).sqrt() / DEG_H;
        let (steepness, name) = slope(term);
        let Some(ends) = axes.slope(tau_s, deviation, steepness) else { continue };
        let ends = ends.map(|(tau_s, deviation)| axes.at(tau_s, deviation));
        let line = DashedPathElement::new(ends, 7, 5, colour(term).stroke_width(2));
        root.draw(&line)?;
        let (x, y) = axes.at(tau_s, deviation);
        let text = format!("{}, slope {name}", term.symbol());
        let at = beside(x, y, steepness);
        label(root, &text, at, 16, colour(term))?;
    }
    Ok(())
}

/// A place for a label below a line, on the side where the line leaves room, within the frame. A
/// flat line has room at its left end, for a curve comes from above.
fn beside(x: i32, y: i32, steepness: f64) -> (i32, i32) {
    let [left, top, right, bottom] = FRAME;
    let x = if steepness < 0.0 {
        x - 120
    } else if steepness > 0.0 {
        x + 14
    } else {
        left
    };
    (x.clamp(left + 12, right - 130), (y + 12).clamp(top + 8, bottom - 30))
}

/// A sum of slopes.
fn model_line(
    root: &Area<'_>,
    axes: &Axes,
    of: &Characterized,
    model: &NoiseModel,
    colour: RGBColor,
) -> Result<(), FigureError> {
    let points = of.found.points.iter().filter(|point| !point.filtered);
    let line = points.map(|p| axes.at(p.tau_s, model.variance(p.tau_s).sqrt() / DEG_H));
    Ok(root.draw(&PathElement::new(line.collect::<Vec<_>>(), colour.stroke_width(3)))?)
}

fn curves(root: &Area<'_>, axes: &Axes, points: &[AllanPoint]) -> Result<(), FigureError> {
    let hadamard: Vec<_> = points
        .iter()
        .filter_map(|p| p.hdev_rad_s.filter(|hdev| *hdev > 0.0).map(|hdev| (p.tau_s, hdev)))
        .map(|(tau_s, hdev)| axes.at(tau_s, hdev / DEG_H))
        .collect();
    root.draw(&PathElement::new(hadamard, FAINT.stroke_width(1)))?;
    for point in points {
        let at = axes.at(point.tau_s, point.adev_rad_s / DEG_H);
        let usable = point.trusted && !point.filtered;
        let style = if usable { CURVE.filled() } else { FAINT.filled() };
        root.draw(&Circle::new(at, if usable { 4 } else { 3 }, style))?;
    }
    Ok(())
}

fn frame(root: &Area<'_>, axes: &Axes) -> Result<(), FigureError> {
    let [left, top, right, bottom] = FRAME;
    root.draw(&Rectangle::new([(left, top), (right, bottom)], TEXT.stroke_width(1)))?;
    let below = style(15, TEXT).pos(Pos::new(HPos::Center, VPos::Top));
    for tick in axes.x_ticks() {
        if let Some(text) = tick.label {
            root.draw(&Text::new(text, (tick.at, bottom + 8), below.clone()))?;
        }
    }
    let aside = style(15, TEXT).pos(Pos::new(HPos::Right, VPos::Center));
    for tick in axes.y_ticks() {
        if let Some(text) = tick.label {
            root.draw(&Text::new(text, (left - 8, tick.at), aside.clone()))?;
        }
    }
    let x_title = style(17, BLACK).pos(Pos::new(HPos::Center, VPos::Top));
    let middle = (left + right) / 2;
    root.draw(&Text::new("averaging time, s", (middle, bottom + 36), x_title))?;
    let y_font = (FONT, 17).into_font().transform(FontTransform::Rotate270);
    let y_title = TextStyle::from(y_font).color(&BLACK).pos(Pos::new(HPos::Center, VPos::Top));
    let place = (26, (top + bottom) / 2);
    Ok(root.draw(&Text::new("Allan deviation, deg/h", place, y_title))?)
}

fn style(size_px: u32, colour: RGBColor) -> TextStyle<'static> {
    let (font, color) = ((FONT, size_px).into_font(), colour.to_backend_color());
    TextStyle { font, color, pos: Pos::default() }
}

fn label(
    root: &Area<'_>,
    text: &str,
    at: (i32, i32),
    size_px: u32,
    colour: RGBColor,
) -> Result<(), FigureError> {
    Ok(root.draw(&Text::new(text.to_owned(), at, style(size_px, colour)))?)
}
