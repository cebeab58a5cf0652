//! Figures of the report, made from rows and nothing else.

mod chart;
mod plane;

use super::requirement::{errors, present};
use super::row::{Column, EPOCHS, Row};
use super::statistics::{Measured, honest_mean_square, mean, mean_square, median, quantile, rms};
use super::suite::Figure;
use crate::figure::FigureError;
use chart::{Chart, Curve, DotRow, dots};

/// Case and estimator.
pub type Cell<'a> = (&'a str, &'a str);

/// Names in the order of their first row.
fn names<'a>(rows: &[&'a Row], of: impl Fn(&'a Row) -> &'a str) -> Vec<&'a str> {
    let mut names = Vec::new();
    for row in rows {
        if !names.contains(&of(row)) {
            names.push(of(row));
        }
    }
    names
}

fn of_cell<'a>(rows: &[&'a Row], (case, estimator): Cell<'_>) -> Vec<&'a Row> {
    let of = |row: &&&Row| row.case == case && row.estimator == estimator;
    rows.iter().filter(of).copied().collect()
}

/// What [`bars`] shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bars {
    /// Title.
    pub title: &'static str,
    /// Column of errors.
    pub column: Column,
    /// Column of the least possible value.
    pub bound: Option<Column>,
    /// Unit.
    pub axis: &'static str,
}

/// A row for each cell: root mean square with its interval, and a tick at the bound.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn bars(rows: &[&Row], of: &Bars) -> Result<Figure, FigureError> {
    let estimators = names(rows, |row| &row.estimator);
    let mut lines = Vec::new();
    for case in names(rows, |row| &row.case) {
        let mut group = Some(case.to_owned());
        for (colour, estimator) in estimators.iter().enumerate() {
            let cell = of_cell(rows, (case, estimator));
            let Some(measured) = rms(&errors(&cell, of.column)) else { continue };
            let bound = of.bound.and_then(|bound| rms(&present(&cell, bound)));
            lines.push(DotRow {
                group: group.take(),
                name: (*estimator).to_owned(),
                measured,
                bound: bound.map(|bound| bound.value),
                colour,
            });
        }
    }
    let note = if of.bound.is_some() { "; upright tick: the least possible" } else { "" };
    let svg = dots(of.title, of.axis, &lines, note)?;
    let mut caption = String::from(
        "Dots: root mean square over all runs; lines: its 95 % interval. At the right edge: runs \
         that stopped, or an error beyond the axis.",
    );
    if of.bound.is_some() {
        caption += " The tick is the error that the best possible filter would be left with.";
    }
    Ok(Figure { caption, svg })
}

/// A row for each cell: how large the errors at the end are in claimed standard deviations, for two
/// thirds and for 95 of 100 runs.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn claims(rows: &[&Row], title: &str) -> Result<Figure, FigureError> {
    let estimators = names(rows, |row| &row.estimator);
    let mut lines = Vec::new();
    for case in names(rows, |row| &row.case) {
        let mut group = Some(case.to_owned());
        for (colour, estimator) in estimators.iter().enumerate() {
            let sigmas = errors(&of_cell(rows, (case, estimator)), Column::EndSigmas);
            let at = |share| quantile(&sigmas, share);
            let (Some(low), Some(value), Some(high)) = (at(0.5), at(0.68), at(0.95)) else {
                continue;
            };
            let name = (*estimator).to_owned();
            let measured = Measured { value, low, high, runs: sigmas.len() };
            lines.push(DotRow { group: group.take(), name, measured, bound: Some(1.0), colour });
        }
    }
    let svg = dots(title, "claimed standard deviations", &lines, "; upright tick: honest")?;
    let caption =
        "Dots: the size that 68 % of the errors stay below, 1 for an honest claim. Lines \
                   span 50 % to 95 %, which an honest claim puts at 0.67 and 1.96. To the right of \
                   the tick: over-confident."
            .to_owned();
    Ok(Figure { caption, svg })
}

/// Percentiles of the angle error along the run against what the estimator claims of it.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn fan(rows: &[&Row], title: &str, of: Cell<'_>) -> Result<Option<Figure>, FigureError> {
    let cell = of_cell(rows, of);
    let Some(duration_s) = cell.iter().find_map(|row| row.get(Column::DurationS)) else {
        return Ok(None);
    };
    let time_s = |at: usize| duration_s * (at + 1) as f64 / EPOCHS as f64;
    let exact = |value: f64| Measured { value, low: value, high: value, runs: cell.len() };
    let mut curves = Vec::new();
    // Half width of a normal interval that holds the share.
    for (colour, (share, sigmas)) in [(0.95, 1.96), (0.68, 0.994), (0.5, 0.674)].iter().enumerate()
    {
        let at = |value: &dyn Fn(&Row, usize) -> f64, share: f64| -> Vec<(f64, Measured)> {
            (0..EPOCHS)
                .filter_map(|epoch| {
                    let values: Vec<f64> = cell
                        .iter()
                        .map(|row| value(row, epoch))
                        .filter(|value| !value.is_nan())
                        .collect();
                    Some((time_s(epoch), exact(quantile(&values, share)?)))
                })
                .collect()
        };
        let claim = |row: &Row, epoch: usize| sigmas * row.epochs[epoch].sigma_deg;
        let error = |row: &Row, epoch: usize| row.epochs[epoch].error_deg.abs();
        let percent = 100.0 * share;
        curves.push(Curve {
            name: format!("{percent:.0} % of errors"),
            points: at(&error, *share),
            dashed: false,
            colour,
        });
        curves.push(Curve {
            name: format!("claimed for {percent:.0} %"),
            points: at(&claim, 0.5),
            dashed: true,
            colour,
        });
    }
    let chart = Chart {
        title: title.to_owned(),
        x_name: "time, s".to_owned(),
        y_name: "angle error, deg".to_owned(),
        log: (false, true),
        curves,
        band: None,
        rules: Vec::new(),
        marks: Vec::new(),
    };
    let caption =
        "Solid: the error that so many per cent of the runs stay below. Dashed: what the \
                   estimator claims for as many (median over runs). An honest claim lies on its \
                   line; one below it is over-confident."
            .to_owned();
    Ok(Some(Figure { caption, svg: chart.draw()? }))
}

/// Mean NEES along the run, a curve for each case.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn nees(rows: &[&Row], title: &str, estimator: &str) -> Result<Option<Figure>, FigureError> {
    let mut curves = Vec::new();
    let mut known = None;
    for (colour, case) in names(rows, |row| &row.case).into_iter().enumerate() {
        let cell = of_cell(rows, (case, estimator));
        let found = |column| cell.iter().find_map(|row| row.get(column));
        let (Some(states), Some(duration_s)) =
            (found(Column::NeesStates), found(Column::DurationS))
        else {
            continue;
        };
        known = Some((states, cell.len()));
        let at = |epoch: usize| {
            let squares = cell.iter().map(|row| row.epochs[epoch].nees).filter(|n| !n.is_nan());
            let measured = mean_square(&squares.collect::<Vec<_>>(), states, 0.05)?;
            Some((duration_s * (epoch + 1) as f64 / EPOCHS as f64, measured))
        };
        let points: Vec<(f64, Measured)> = (0..EPOCHS).filter_map(at).collect();
        curves.push(Curve { name: case.to_owned(), points, dashed: false, colour });
    }
    let Some((states, runs)) = known else { return Ok(None) };
    let band = honest_mean_square(states, runs, 0.05)
        .map(|(low, high)| (low, high, "95 % of honest claims".to_owned()));
    let chart = Chart {
        title: title.to_owned(),
        x_name: "time, s".to_owned(),
        y_name: format!("mean NEES, {states} states"),
        log: (false, false),
        curves,
        band,
        rules: vec![(states, "honest".to_owned())],
        marks: Vec::new(),
    };
    let caption = "Mean over runs of the squared error of the whole state in units of its claimed \
                   covariance; for an honest claim it is the number of states. Above: \
                   over-confident."
        .to_owned();
    Ok(Some(Figure { caption, svg: chart.draw()? }))
}

/// Median delay against size of a kick, a curve for each time over which it is spread.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn delays(rows: &[&Row], title: &str, estimator: &str) -> Result<Option<Figure>, FigureError> {
    let mut cells: Vec<(f64, f64, Measured)> = Vec::new();
    for case in names(rows, |row| &row.case) {
        let cell = of_cell(rows, (case, estimator));
        let first = |column| cell.iter().find_map(|row| row.get(column));
        let (Some(size), Some(over_s)) = (first(Column::KickDegS), first(Column::KickOverS)) else {
            continue;
        };
        let delays = errors(&cell, Column::DelayS);
        let (Some(middle), Some(early), Some(late)) =
            (median(&delays), quantile(&delays, 0.1), quantile(&delays, 0.9))
        else {
            continue;
        };
        cells.push((over_s, size, Measured { low: early, high: late, ..middle }));
    }
    cells.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut curves: Vec<Curve> = Vec::new();
    for (over_s, size, measured) in cells {
        let name =
            if over_s > 0.0 { format!("spread over {over_s} s") } else { "at once".to_owned() };
        let colour = curves.len();
        if curves.last().is_none_or(|curve| curve.name != name) {
            curves.push(Curve { name, points: Vec::new(), dashed: false, colour });
        }
        if let Some(curve) = curves.last_mut() {
            curve.points.push((size, measured));
        }
    }
    let chart = Chart {
        title: title.to_owned(),
        x_name: "change of the rate, deg/s".to_owned(),
        y_name: "delay, s".to_owned(),
        log: (true, true),
        curves,
        band: None,
        rules: Vec::new(),
        marks: Vec::new(),
    };
    let caption = "Median time from the beginning of the change to the alarm; lines span 80 % of \
                   the runs."
        .to_owned();
    Ok((!chart.curves.is_empty()).then_some(Figure { caption, svg: chart.draw()? }))
}

/// What [`against`] shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Against {
    /// Title.
    pub title: &'static str,
    /// Column along x.
    pub x: Column,
    /// Its name for people.
    pub x_name: &'static str,
    /// Column of errors.
    pub y: Column,
    /// Its name for people.
    pub y_name: &'static str,
}

/// Median of a column against a quantity that is the same in all runs of a case, a curve for each
/// estimator.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn against(rows: &[&Row], of: &Against) -> Result<Option<Figure>, FigureError> {
    let cases = names(rows, |row| &row.case);
    let mut curves = Vec::new();
    for (colour, estimator) in names(rows, |row| &row.estimator).into_iter().enumerate() {
        let at = |case: &&str| {
            let cell = of_cell(rows, (case, estimator));
            let x = cell.iter().find_map(|row| row.get(of.x))?;
            Some((x, median(&errors(&cell, of.y))?))
        };
        let mut points: Vec<(f64, Measured)> = cases.iter().filter_map(at).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        curves.push(Curve { name: estimator.to_owned(), points, dashed: false, colour });
    }
    let chart = Chart {
        title: of.title.to_owned(),
        x_name: of.x_name.to_owned(),
        y_name: of.y_name.to_owned(),
        log: (false, true),
        curves,
        band: None,
        rules: Vec::new(),
        marks: Vec::new(),
    };
    let caption = "Median over runs with its 95 % interval.".to_owned();
    Ok(Some(Figure { caption, svg: chart.draw()? }))
}

/// Root mean square of a column against the length of the refinement, with the best one marked.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn refinement(
    rows: &[&Row],
    title: &str,
    case: &str,
    column: Column,
) -> Result<Option<Figure>, FigureError> {
    let mut curves = Vec::new();
    let mut marks = Vec::new();
    let of_case = names(rows, |row| &row.estimator);
    for (colour, (family, name)) in
        [("F1", "permanent rotation"), ("F2", "torsional oscillation")].into_iter().enumerate()
    {
        let mut points = Vec::new();
        for estimator in of_case.iter().filter(|name| name.starts_with(family)) {
            let cell = of_cell(rows, (case, estimator));
            let length = cell.iter().find_map(|row| row.get(Column::RefinementSamples));
            // N = 0 has no place on a logarithmic axis; half a sample stands for it.
            let (Some(length), Some(measured)) = (length, mean(&errors(&cell, column))) else {
                continue;
            };
            points.push((length.max(0.5), measured));
        }
        let least = points.iter().min_by(|a, b| a.1.value.total_cmp(&b.1.value));
        if let Some((length, measured)) = least {
            marks.push((*length, measured.value, format!("N = {length}")));
        }
        curves.push(Curve { name: name.to_owned(), points, dashed: false, colour });
    }
    let integral = mean(&errors(&of_cell(rows, (case, "integration")), column));
    let rules = integral.map(|integral| (integral.value, "plain integration".to_owned()));
    let chart = Chart {
        title: title.to_owned(),
        x_name: "N, samples; 0.5 stands for 0".to_owned(),
        y_name: format!("RMS, {}", if column == Column::RateRmsDegS { "deg/s" } else { "deg" }),
        log: (true, true),
        curves,
        band: None,
        rules: rules.into_iter().collect(),
        marks,
    };
    let caption =
        "Root mean square of the error over a run, mean over runs with its 95 % interval. \
                   Rings: the least."
            .to_owned();
    Ok(Some(Figure { caption, svg: chart.draw()? }))
}
