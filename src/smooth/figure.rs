//! A picture of a record in hindsight: rates above, angles below; signals left, what is left of
//! them right.

use super::hindsight::Hindsight;
use crate::figure::{
    Curve, FONT, FigureError, HEAD_PX, SIZE_PX, estimator_style, gyro_style, panel, truth_style,
};
use crate::record::Record;
use plotters::coord::Shift;
use plotters::prelude::{
    DrawingArea, DrawingBackend, IntoDrawingArea, PathElement, RGBColor, SVGBackend, Text, WHITE,
};
use plotters::style::{Color, ShapeStyle};
use std::borrow::Cow;

const LEGEND_STEP_PX: i32 = 190;
const SIGMA_GREY: RGBColor = RGBColor(120, 120, 120);

/// Draws the record of [`super::text::record`] as SVG text.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn svg(record: &Record, hindsight: &Hindsight, title: &str) -> Result<String, FigureError> {
    let column = |name: &str| record.column(name).unwrap_or_default();
    let of = |signal: &str| column(&format!("{}.{signal}", hindsight.method)).to_vec();
    let truth = record.column("truth.twist_rad");
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE_PX).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(HEAD_PX);
        head.draw(&Text::new(title.to_owned(), (24, 12), (FONT, 24)))?;
        legend(&head, hindsight.method, truth.is_some())?;
        let panels = body.split_evenly((2, 2));
        let time_s = column("time");
        let measured = column("measured_rate_rad_s");
        let (rate, angle, sigma) = (of("rate_rad_s"), of("angle_rad"), of("angle_sigma_rad"));
        let residual = of("residual_rad_s");
        let rates = [curve(measured, gyro_style()), curve(&rate, estimator_style(0))];
        panel(&panels[0], "rate, deg/s", time_s, &rates)?;
        let left = [curve(&residual, gyro_style())];
        panel(&panels[1], "measured - rate - bias, deg/s", time_s, &left)?;
        let drawn = truth.map(|truth| curve(truth, truth_style()));
        let angles: Vec<_> = drawn.into_iter().chain([curve(&angle, estimator_style(0))]).collect();
        panel(&panels[2], "angle, deg", time_s, &angles)?;
        let errors: Option<Vec<f64>> =
            truth.map(|truth| angle.iter().zip(truth).map(|(a, t)| a - t).collect());
        let label = if errors.is_some() {
            "angle error and claimed 3 sigma, deg"
        } else {
            "claimed 3 sigma of the angle, deg"
        };
        panel(&panels[3], label, time_s, &error_curves(errors, &sigma))?;
        root.present()?;
    }
    Ok(text)
}

fn curve(values: &[f64], style: ShapeStyle) -> Curve<'_> {
    Curve { values: Cow::Borrowed(values), style }
}

fn error_curves(errors: Option<Vec<f64>>, sigma: &[f64]) -> Vec<Curve<'static>> {
    let bound = |sign: f64| Curve {
        values: Cow::Owned(sigma.iter().map(|sigma| 3.0 * sign * sigma).collect()),
        style: SIGMA_GREY.stroke_width(1),
    };
    let errors = errors.map(|e| Curve { values: Cow::Owned(e), style: estimator_style(0) });
    [bound(1.0), bound(-1.0)].into_iter().chain(errors).collect()
}

fn legend<B>(
    head: &DrawingArea<B, Shift>,
    method: &str,
    with_truth: bool,
) -> Result<(), FigureError>
where
    B: DrawingBackend,
    B::ErrorType: std::error::Error + Send + Sync + 'static,
{
    let truth = with_truth.then(|| ("truth", truth_style()));
    let entries = [("gyro", gyro_style()), (method, estimator_style(0))];
    let sigma = [("claimed 3 sigma", SIGMA_GREY.stroke_width(1))];
    let mut x = 28;
    for (label, style) in entries.into_iter().chain(truth).chain(sigma) {
        head.draw(&PathElement::new([(x, 56), (x + 30, 56)], style))?;
        head.draw(&Text::new(label.to_owned(), (x + 38, 48), (FONT, 16)))?;
        x += LEGEND_STEP_PX;
    }
    Ok(())
}
