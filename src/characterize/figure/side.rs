//! What stands beside the picture: title, legend and coefficients.

use super::super::Characterized;
use super::super::text::time;
use super::super::unit::{of_term, on_data_sheet, plain, significant};
use super::{
    Area, BLACK, BOUND, CURVE, FAINT, FRAME, FigureError, MODEL, TEXT, colour, label, style,
};
use plotters::prelude::{Circle, PathElement, RGBColor, Rectangle, Text};
use plotters::style::Color;
use struna_gyro::characterise::{MISFIT_REFUSED, Reason, Term, Verdict};

/// Left edge of the coefficients.
const SIDE_PX: i32 = 930;
const ROW_PX: i32 = 88;
/// Names are cut to what fits beside each other.
const NAME_CHARS_MAX: usize = 60;

pub(super) fn draw(root: &Area<'_>, of: &Characterized) -> Result<(), FigureError> {
    head(root, of)?;
    legend(root, of)?;
    for (k, term) in (0..).zip(Term::ALL) {
        coefficient(root, of, term, FRAME[1] + k * ROW_PX)?;
    }
    laboratory(root, of)
}

fn head(root: &Area<'_>, of: &Characterized) -> Result<(), FigureError> {
    let name: String = of.name.chars().filter(|c| !c.is_control()).take(NAME_CHARS_MAX).collect();
    label(root, &format!("{name}: noise at rest"), (FRAME[0], 18), 25, BLACK)?;
    let record = &of.record;
    let mut about =
        format!("{} at {} Hz", time(record.duration_s()), plain(record.sample_rate_hz(), 6));
    if record.lost() > 0 {
        about += &format!(", {} samples lost", record.lost());
    }
    label(root, &about, (SIDE_PX, 26), 15, TEXT)
}

fn legend(root: &Area<'_>, of: &Characterized) -> Result<(), FigureError> {
    let y = 76;
    let mut x = FRAME[0];
    let mut entry = |text: &str, width: i32, draw: &dyn Fn(i32) -> Result<(), FigureError>| {
        draw(x)?;
        label(root, text, (x + 36, y - 8), 15, TEXT)?;
        x += width;
        Ok::<(), FigureError>(())
    };
    let stroke = |colour: RGBColor, width: u32| {
        move |x: i32| {
            let line = PathElement::new([(x, y), (x + 28, y)], colour.stroke_width(width));
            Ok(root.draw(&line)?)
        }
    };
    let confidence = plain(100.0 * of.options.confidence, 3);
    entry(&format!("Allan deviation, {confidence} % interval"), 270, &|x| {
        let band = Rectangle::new([(x, y - 8), (x + 28, y + 8)], CURVE.mix(0.16).filled());
        root.draw(&band)?;
        Ok(root.draw(&Circle::new((x + 14, y), 4, CURVE.filled()))?)
    })?;
    if of.found.misfit <= MISFIT_REFUSED {
        entry("fit", 80, &stroke(MODEL, 3))?;
    }
    entry("Hadamard deviation", 190, &stroke(FAINT, 1))?;
    if of.found.overbound.is_some() {
        entry("bound above the interval", 200, &stroke(BOUND, 3))?;
    }
    Ok(())
}

/// Name, value and interval of a coefficient.
fn coefficient(root: &Area<'_>, of: &Characterized, term: Term, y: i32) -> Result<(), FigureError> {
    let (unit, ..) = of_term(term);
    let number = |value| significant(on_data_sheet(term, value), 3);
    let (value, remark, ink) = match of.found.verdict(term) {
        Verdict::Estimated { value, interval: [low, high] } => {
            let remark = format!("{} to {}", number(low), number(high));
            (format!("{} {unit}", number(value)), remark, BLACK)
        }
        Verdict::AtMost { bound, reason } => {
            let remark = match reason {
                Reason::NotARamp => "no ramp: Hadamard rises too",
                Reason::Loose => "cannot be told from none",
                _ => "does not show in this record",
            };
            (format!("at most {} {unit}", number(bound)), remark.to_owned(), TEXT)
        }
        Verdict::Refused { reason } => {
            let remark = match reason {
                Reason::NoSlopes { .. } => "the curve is no sum of slopes",
                _ => "the record is too short",
            };
            ("no answer".to_owned(), remark.to_owned(), FAINT)
        }
    };
    let shown = of.found.model.has(term) && of.found.misfit <= MISFIT_REFUSED;
    let mark = if shown { colour(term) } else { FAINT };
    root.draw(&Rectangle::new([(SIDE_PX, y), (SIDE_PX + 4, y + 66)], mark.filled()))?;
    let name = format!("{}   {}", term.symbol(), term.name());
    root.draw(&Text::new(name, (SIDE_PX + 16, y), style(15, TEXT)))?;
    label(root, &value, (SIDE_PX + 16, y + 22), 20, ink)?;
    label(root, &remark, (SIDE_PX + 16, y + 49), 14, TEXT)
}

/// The laboratory's statistic of the averages, in a line each.
fn laboratory(root: &Area<'_>, of: &Characterized) -> Result<(), FigureError> {
    let y = FRAME[1] + 5 * ROW_PX + 8;
    let Some(lab) = of.found.laboratory[1] else { return Ok(()) };
    let deg_s = |rad_s: f64| significant(rad_s.to_degrees(), 3);
    let lines = [
        format!("averages of {} samples", lab.averaging),
        format!("half of the range {} deg/s", deg_s(lab.half_range_rad_s)),
        format!("over d(n) = {:.2}: {} deg/s", lab.bias_factor, deg_s(lab.debiased_sigma_rad_s())),
        format!("standard deviation {} deg/s", deg_s(lab.sigma_rad_s)),
        format!("variance over white {}", significant(lab.excess_over_white(), 3)),
    ];
    let x = (SIDE_PX, SIDE_PX + 280);
    root.draw(&PathElement::new([(x.0, y - 14), (x.1, y - 14)], FAINT.stroke_width(1)))?;
    for (k, line) in (0..).zip(lines) {
        let ink = if k == 0 { BLACK } else { TEXT };
        label(root, &line, (SIDE_PX, y + 26 * k), 15, ink)?;
    }
    Ok(())
}
