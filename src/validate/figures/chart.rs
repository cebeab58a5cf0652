//! Curves over a quantity, and dots in rows.

use super::plane::{Area, Drawn, INK, PALETTE, Plane, Scale, figure, ink, title, write};
use crate::figure::FigureError;
use crate::validate::statistics::Measured;
use plotters::prelude::{Circle, PathElement, RGBColor};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// Width of all figures, pixels.
const WIDTH_PX: u32 = 980;
const CURVE_HEIGHT_PX: u32 = 460;
/// Where the frame of curves ends and their names begin.
const CURVE_RIGHT_PX: i32 = 730;
const ROW_PX: i32 = 21;
const ROWS_LEFT_PX: i32 = 400;

/// A curve with intervals.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub(super) name: String,
    /// Place and what is measured there.
    pub(super) points: Vec<(f64, Measured)>,
    /// Claims are dashed; what is measured is not, and has dots.
    pub(super) dashed: bool,
    /// Index of its colour.
    pub(super) colour: usize,
}

/// A chart of curves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chart {
    pub(super) title: String,
    pub(super) x_name: String,
    pub(super) y_name: String,
    /// Whether the axes are logarithmic.
    pub(super) log: (bool, bool),
    pub(super) curves: Vec<Curve>,
    /// Band between two values of y, with a name.
    pub(super) band: Option<(f64, f64, String)>,
    /// Horizontal lines with names.
    pub(super) rules: Vec<(f64, String)>,
    /// A place to point out, with a name.
    pub(super) marks: Vec<(f64, f64, String)>,
}

impl Chart {
    pub(super) fn draw(&self) -> Result<String, FigureError> {
        figure((WIDTH_PX, CURVE_HEIGHT_PX), |area| {
            title(area, &self.title)?;
            let plane = self.plane();
            if let Some((low, high, _)) = &self.band {
                let ends = |y: f64| [plane.x_low(y), plane.x_high(y)];
                plane.band(area, [&ends(*low), &ends(*high)], PALETTE[6])?;
            }
            plane.draw(area, &self.x_name, Some(&self.y_name))?;
            let mut at = LegendRow::default();
            self.rules(area, &plane)?;
            for curve in &self.curves {
                draw_curve(area, &plane, curve)?;
                at.write(area, curve)?;
            }
            if let Some((_, _, name)) = &self.band {
                at.note(area, name)?;
            }
            self.marks(area, &plane)
        })
    }

    fn plane(&self) -> Plane {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let xs = points().map(|(x, _)| *x);
        let band = self.band.iter().flat_map(|(low, high, _)| [*low, *high]);
        let rules = self.rules.iter().map(|(y, _)| *y);
        let ends = points().flat_map(|(_, m)| [m.value, m.low.max(0.3 * m.value), m.high]);
        let ends = ends.chain(band).chain(rules);
        let x = if self.log.0 { Scale::log_around(xs) } else { Scale::linear_around(xs) };
        let y = if self.log.1 { Scale::log_around(ends) } else { Scale::linear_around(ends) };
        Plane { frame: [86, 48, CURVE_RIGHT_PX, 398], x, y }
    }

    fn rules(&self, area: &Area<'_>, plane: &Plane) -> Drawn {
        for (y, name) in &self.rules {
            let line = [plane.x_low(*y), plane.x_high(*y)];
            plane.line(area, &line, INK, true)?;
            let (right, at) = (plane.frame[2], plane.y(*y));
            write(area, name, (right - 6, at - 4), (HPos::Right, VPos::Bottom), INK)?;
        }
        Ok(())
    }

    fn marks(&self, area: &Area<'_>, plane: &Plane) -> Drawn {
        for (x, y, name) in &self.marks {
            let at = plane.at((*x, *y));
            area.draw(&Circle::new(at, 9, INK.stroke_width(2)))?;
            // Below, for a least value is the bottom of its curve; above where the frame ends.
            let (y, side) = match at.1 {
                y if y + 40 > plane.frame[3] => (y - 14, VPos::Bottom),
                y => (y + 14, VPos::Top),
            };
            write(area, name, (at.0, y), (HPos::Center, side), INK)?;
        }
        Ok(())
    }
}

impl Plane {
    /// The left end of the frame at a height; held there whatever the axis.
    fn x_low(&self, y: f64) -> (f64, f64) {
        (f64::NEG_INFINITY, y)
    }

    fn x_high(&self, y: f64) -> (f64, f64) {
        (f64::INFINITY, y)
    }
}

fn draw_curve(area: &Area<'_>, plane: &Plane, curve: &Curve) -> Drawn {
    let colour = PALETTE[curve.colour % PALETTE.len()];
    let line: Vec<(f64, f64)> = curve.points.iter().map(|(x, m)| (*x, m.value)).collect();
    plane.line(area, &line, colour, curve.dashed)?;
    if curve.dashed {
        return Ok(());
    }
    for (x, measured) in &curve.points {
        plane.dot(area, (*x, measured.value, measured.low, measured.high), colour)?;
    }
    Ok(())
}

/// Names beside the frame, one below the other.
#[derive(Default)]
struct LegendRow(i32);

impl LegendRow {
    fn write(&mut self, area: &Area<'_>, curve: &Curve) -> Drawn {
        let colour = PALETTE[curve.colour % PALETTE.len()];
        let y = self.next();
        let (from, to) = (CURVE_RIGHT_PX + 16, CURVE_RIGHT_PX + 42);
        let dashes =
            if curve.dashed { vec![(from, from + 9), (to - 9, to)] } else { vec![(from, to)] };
        for (a, b) in dashes {
            area.draw(&PathElement::new([(a, y), (b, y)], colour.stroke_width(3)))?;
        }
        write(area, &curve.name, (to + 8, y), (HPos::Left, VPos::Center), INK)
    }

    fn note(&mut self, area: &Area<'_>, name: &str) -> Drawn {
        let y = self.next();
        write(area, name, (CURVE_RIGHT_PX + 16, y), (HPos::Left, VPos::Center), PALETTE[6])
    }

    fn next(&mut self) -> i32 {
        self.0 += 1;
        42 + 22 * self.0
    }
}

/// A row of a dot chart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DotRow {
    /// Head of the group, where one begins.
    pub(super) group: Option<String>,
    pub(super) name: String,
    pub(super) measured: Measured,
    /// Where a tick stands: the least possible value.
    pub(super) bound: Option<f64>,
    pub(super) colour: usize,
}

/// Dots with intervals in named rows over one logarithmic axis.
pub(super) fn dots(
    name: &str,
    axis: &str,
    rows: &[DotRow],
    note: &str,
) -> Result<String, FigureError> {
    let count = i32::try_from(rows.len()).unwrap_or(i32::MAX / 100).min(2000);
    let groups = i32::try_from(rows.iter().filter(|r| r.group.is_some()).count()).unwrap_or(0);
    let (top, height) = (52, ROW_PX * count + 8 * groups.min(2000) + 8);
    let size = (WIDTH_PX, (top + height + 64).unsigned_abs());
    figure(size, |area| {
        title(area, name)?;
        let ends = rows.iter().flat_map(|row| {
            let Measured { value, low, high, .. } = row.measured;
            [value, low.max(0.3 * value), high, row.bound.unwrap_or(value)]
        });
        let x = Scale::log_around(ends);
        let frame = [ROWS_LEFT_PX, top, 950, top + height];
        let plane = Plane { frame, x, y: Scale::linear_around([0.0, 1.0].into_iter()) };
        plane.draw(area, &format!("{axis}{note}"), None)?;
        let mut y = top + 4;
        for row in rows {
            if let Some(group) = &row.group {
                y += 8;
                let rule = [(16, y - 6), (950, y - 6)];
                area.draw(&PathElement::new(rule, ink(0.13)))?;
                write(area, group, (16, y + ROW_PX / 2), (HPos::Left, VPos::Center), INK)?;
            }
            dot_row(area, &plane, row, y + ROW_PX / 2)?;
            y += ROW_PX;
        }
        Ok(())
    })
}

fn dot_row(area: &Area<'_>, plane: &Plane, row: &DotRow, y: i32) -> Drawn {
    let colour: RGBColor = PALETTE[row.colour % PALETTE.len()];
    write(area, &row.name, (ROWS_LEFT_PX - 10, y), (HPos::Right, VPos::Center), INK)?;
    if let Some(bound) = row.bound {
        let x = plane.x(bound);
        area.draw(&PathElement::new([(x, y - 9), (x, y + 9)], INK.stroke_width(3)))?;
    }
    let Measured { value, low, high, .. } = row.measured;
    let stem = [(plane.x(low), y), (plane.x(high), y)];
    area.draw(&PathElement::new(stem, colour.stroke_width(3)))?;
    Ok(area.draw(&Circle::new((plane.x(value), y), 5, colour.filled()))?)
}
