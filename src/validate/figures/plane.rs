//! A frame with two axes, linear or logarithmic, and what is drawn into it.
//!
//! Ink has a colour that is put in place of later: the report's own text colour, light or dark.

use crate::figure::FigureError;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, IntoFont, PathElement, Polygon, RGBColor, Rectangle,
    SVGBackend, Text, TextStyle,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform};

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn = Result<(), FigureError>;

const FONT: &str = "sans-serif";
/// Stands for the colour of text around the figure; see [`figure`].
pub(super) const INK: RGBColor = RGBColor(1, 2, 3);
const FRAME_OPACITY: f64 = 0.55;
const GRID_OPACITY: f64 = 0.13;
/// Colours that stay apart for colour-blind readers (Okabe and Ito, 2008), dark enough on white and
/// light enough on black.
pub(super) const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 128, 190),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(190, 140, 0),
    RGBColor(110, 110, 215),
    RGBColor(128, 128, 128),
    RGBColor(86, 180, 233),
];

/// Draws a figure of a size in pixels as SVG text, transparent, its ink the text around it.
pub(super) fn figure(
    size_px: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<String, FigureError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size_px).into_drawing_area();
        draw(&root)?;
        root.present()?;
    }
    Ok(text.replace("#010203", "currentColor").replacen("<svg ", "<svg role=\"img\" ", 1))
}

/// One axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    from: f64,
    to: f64,
    log: bool,
}

/// A line of the grid with its label.
struct Tick {
    at: f64,
    label: Option<String>,
}

impl Scale {
    /// A logarithmic axis around positive values; what is not positive or not finite is left out.
    pub(super) fn log_around(values: impl Iterator<Item = f64>) -> Self {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
        let (low, high) = extent(logs).unwrap_or((0.0, 1.0));
        let margin = 0.06 * (high - low).max(0.5);
        Self { from: low - margin, to: high + margin, log: true }
    }

    /// A linear axis around values and zero.
    pub(super) fn linear_around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = extent(values.filter(|v| v.is_finite())).unwrap_or((0.0, 1.0));
        let (low, high) = (low.min(0.0), high.max(0.0));
        let margin = 0.06 * (high - low).max(1e-9);
        Self { from: if low < 0.0 { low - margin } else { 0.0 }, to: high + margin, log: false }
    }

    /// Place of a value along the axis, from 0 to 1 and held there.
    fn share(&self, value: f64) -> f64 {
        let value = if self.log { value.max(f64::MIN_POSITIVE).log10() } else { value };
        ((value - self.from) / (self.to - self.from)).clamp(0.0, 1.0)
    }

    fn ticks(&self) -> Vec<Tick> {
        if self.log { self.log_ticks() } else { self.linear_ticks() }
    }

    fn log_ticks(&self) -> Vec<Tick> {
        let decades = self.to - self.from;
        #[expect(clippy::cast_possible_truncation, reason = "decades of doubles: within 700")]
        let (first, last) = (self.from.floor() as i32, self.to.ceil() as i32);
        let mut ticks = Vec::new();
        for decade in first..=last {
            for digit in 1..=9_u8 {
                let at = f64::from(digit) * 10.0_f64.powi(decade);
                let named = digit == 1 || (decades < 3.0 && [2, 5].contains(&digit));
                if (self.from..=self.to).contains(&at.log10()) && (named || decades < 4.0) {
                    ticks.push(Tick { at, label: named.then(|| number(at)) });
                }
            }
        }
        ticks
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let span = self.to - self.from;
        let raw = span / 6.0;
        let decade = 10.0_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= raw);
        let step = step.unwrap_or(decade);
        let first = (self.from / step).ceil();
        (0..16)
            .map(|k| (first + f64::from(k)) * step)
            .take_while(|at| *at <= self.to)
            .map(|at| Tick { at, label: Some(number(at)) })
            .collect()
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |sofar, v| {
        Some(sofar.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v))))
    })
}

/// A tick's number, without a tail of rounding.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A frame in pixels with its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    /// Left, top, right, bottom.
    pub(super) frame: [i32; 4],
    pub(super) x: Scale,
    pub(super) y: Scale,
}

impl Plane {
    pub(super) fn x(&self, value: f64) -> i32 {
        let [left, _, right, _] = self.frame;
        left + pixels(self.x.share(value), right - left)
    }

    pub(super) fn y(&self, value: f64) -> i32 {
        let [_, top, _, bottom] = self.frame;
        bottom - pixels(self.y.share(value), bottom - top)
    }

    pub(super) fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        (self.x(x), self.y(y))
    }

    /// Grid, frame and labels of the x axis; those of the y axis too when it is named.
    pub(super) fn draw(&self, area: &Area<'_>, x_name: &str, y_name: Option<&str>) -> Drawn {
        let [left, top, right, bottom] = self.frame;
        for tick in self.x.ticks() {
            let x = self.x(tick.at);
            area.draw(&PathElement::new([(x, top), (x, bottom)], ink(GRID_OPACITY)))?;
            if let Some(text) = tick.label {
                write(area, &text, (x, bottom + 8), (HPos::Center, VPos::Top), INK)?;
            }
        }
        let y_ticks = if y_name.is_some() { self.y.ticks() } else { Vec::new() };
        for tick in y_ticks {
            let y = self.y(tick.at);
            area.draw(&PathElement::new([(left, y), (right, y)], ink(GRID_OPACITY)))?;
            if let Some(text) = tick.label {
                write(area, &text, (left - 8, y), (HPos::Right, VPos::Center), INK)?;
            }
        }
        let frame = Rectangle::new([(left, top), (right, bottom)], ink(FRAME_OPACITY));
        area.draw(&frame)?;
        let below = ((left + right) / 2, bottom + 32);
        write(area, x_name, below, (HPos::Center, VPos::Top), INK)?;
        let Some(y_name) = y_name else { return Ok(()) };
        let font = (FONT, 15).into_font().transform(FontTransform::Rotate270);
        let style = TextStyle::from(font).color(&INK).pos(Pos::new(HPos::Center, VPos::Top));
        Ok(area.draw(&Text::new(y_name.to_owned(), (14, (top + bottom) / 2), style))?)
    }

    /// A line through points.
    pub(super) fn line(
        &self,
        area: &Area<'_>,
        points: &[(f64, f64)],
        colour: RGBColor,
        dashed: bool,
    ) -> Drawn {
        let path: Vec<_> = points.iter().map(|point| self.at(*point)).collect();
        let style = colour.stroke_width(2);
        if dashed {
            return Ok(area.draw(&DashedPathElement::new(path, 6, 5, style))?);
        }
        Ok(area.draw(&PathElement::new(path, style))?)
    }

    /// A faint band between two lines over the same places.
    pub(super) fn band(
        &self,
        area: &Area<'_>,
        [low, high]: [&[(f64, f64)]; 2],
        colour: RGBColor,
    ) -> Drawn {
        let outline = low.iter().chain(high.iter().rev()).map(|point| self.at(*point));
        Ok(area.draw(&Polygon::new(outline.collect::<Vec<_>>(), colour.mix(0.15).filled()))?)
    }

    /// A dot with an interval along y.
    pub(super) fn dot(
        &self,
        area: &Area<'_>,
        (x, value, low, high): (f64, f64, f64, f64),
        colour: RGBColor,
    ) -> Drawn {
        let stem = [self.at((x, low)), self.at((x, high))];
        area.draw(&PathElement::new(stem, colour.stroke_width(2)))?;
        Ok(area.draw(&Circle::new(self.at((x, value)), 4, colour.filled()))?)
    }
}

fn pixels(share: f64, length: i32) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "a share of a picture's size")]
    let pixels = (share * f64::from(length)).round() as i32;
    pixels
}

pub(super) fn ink(opacity: f64) -> plotters::style::RGBAColor {
    INK.mix(opacity)
}

/// Text of the figure's size at a place, anchored as told.
pub(super) fn write(
    area: &Area<'_>,
    text: &str,
    at: (i32, i32),
    (horizontal, vertical): (HPos, VPos),
    colour: RGBColor,
) -> Drawn {
    let style = TextStyle::from((FONT, 15).into_font()).color(&colour);
    let style = style.pos(Pos::new(horizontal, vertical));
    Ok(area.draw(&Text::new(text.to_owned(), at, style))?)
}

/// A title at the top left.
pub(super) fn title(area: &Area<'_>, text: &str) -> Drawn {
    let style = TextStyle::from((FONT, 19).into_font()).color(&INK);
    Ok(area.draw(&Text::new(text.to_owned(), (16, 12), style))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let scale = Scale::log_around([0.02, 130.0].into_iter());
        let labels: Vec<String> = scale.ticks().into_iter().filter_map(|t| t.label).collect();
        assert_eq!(labels, ["0.1", "1", "10", "100"]);
        let scale = Scale::linear_around([3.0, 6.2].into_iter());
        let labels: Vec<String> = scale.ticks().into_iter().filter_map(|t| t.label).collect();
        assert_eq!(labels, ["0", "2", "4", "6"]);
    }

    #[test]
    fn places_beyond_the_axis_are_held_at_its_ends() {
        let x = Scale::log_around([1.0, 10.0].into_iter());
        let plane = Plane { frame: [100, 0, 200, 50], x, y: x };
        assert_eq!((plane.x(0.0), plane.x(f64::INFINITY)), (100, 200));
        assert_eq!((plane.y(1e-9), plane.y(1e9)), (50, 0));
    }
}
