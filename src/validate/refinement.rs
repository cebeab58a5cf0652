//! The best length of the covariance refinement, from errors of filters with several.

use super::requirement::errors;
use super::row::{Column, Row};
use super::statistics::{Measured, mean};

/// A length and the squared errors of its runs.
type Cell = (f64, Vec<f64>);

/// Length at which the mean square of a column is least among the filters whose names begin so.
///
/// The least of some lengths says little of a smooth minimum: the vertex of a parabola through the
/// logarithms of length and error, from half to twice the least, says it to a per cent or two. Its
/// interval is that of the jackknife over runs, for all lengths see the same ones. Where a minimum
/// is so flat that a run more or less takes the vertex away, the least is told as it is, with all
/// lengths whose errors differ from its no more, run by run, than chance would have it.
pub(super) fn best(rows: &[&Row], family: &str, column: Column) -> Option<Measured> {
    let cells = cells(rows, family, column);
    let runs = cells.iter().map(|(_, squares)| squares.len()).min()?;
    if cells.iter().any(|(_, squares)| squares.len() != runs) {
        return None;
    }
    let sum = |cell: &Cell| cell.1.iter().sum::<f64>();
    let least = cells.iter().min_by(|a, b| sum(a).total_cmp(&sum(b)))?;
    let near = |cell: &&Cell| (0.49..2.05).contains(&(cell.0 / least.0)) && sum(cell).is_finite();
    let valley: Vec<&Cell> = cells.iter().filter(near).collect();
    of_valley(&valley, runs).or_else(|| alike(&cells, least))
}

/// The vertex with its jackknife.
fn of_valley(valley: &[&Cell], runs: usize) -> Option<Measured> {
    let all = vertex(valley, None)?;
    let n = runs as f64;
    let pseudo = (0..runs).map(|left_out| {
        let without = vertex(valley, Some(left_out))?;
        Some(n * all - (n - 1.0) * without)
    });
    let found = mean(&pseudo.collect::<Option<Vec<f64>>>()?)?;
    let half = 0.5 * (found.high - found.low);
    Some(Measured { value: all.exp(), low: (all - half).exp(), high: (all + half).exp(), runs })
}

/// The least, and from the first to the last length that cannot be told from it.
fn alike(cells: &[Cell], least: &Cell) -> Option<Measured> {
    let is_alike = |cell: &&Cell| {
        let differences: Vec<f64> = cell.1.iter().zip(&least.1).map(|(a, b)| a - b).collect();
        mean(&differences).is_some_and(|difference| difference.low <= 0.0)
    };
    let lengths = || cells.iter().filter(is_alike).map(|(length, _)| *length);
    let (low, high) = (lengths().next()?, lengths().next_back()?);
    Some(Measured { value: least.0, low, high, runs: least.1.len() })
}

fn cells(rows: &[&Row], family: &str, column: Column) -> Vec<Cell> {
    let of_family = || rows.iter().copied().filter(|row| row.estimator.starts_with(family));
    let mut lengths: Vec<f64> =
        of_family().filter_map(|row| row.get(Column::RefinementSamples)).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    // Without a refinement there is no length.
    lengths.retain(|length| *length > 0.0);
    let of = |length: f64| {
        let cell: Vec<&Row> =
            of_family().filter(|row| row.get(Column::RefinementSamples) == Some(length)).collect();
        (length, errors(&cell, column).iter().map(|error| error * error).collect())
    };
    lengths.into_iter().map(of).collect()
}

/// Logarithm of the length where the parabola through all points is lowest, by least squares. None
/// where it has no lowest point between them.
fn vertex(cells: &[&Cell], left_out: Option<usize>) -> Option<f64> {
    let log_error = |squares: &[f64]| {
        let kept = squares.iter().enumerate().filter(|(run, _)| Some(*run) != left_out);
        kept.map(|(_, square)| square).sum::<f64>().ln()
    };
    let points: Vec<(f64, f64)> =
        cells.iter().map(|(length, squares)| (length.ln(), log_error(squares))).collect();
    let (first, last) = (points.first()?.0, points.last()?.0);
    let middle = 0.5 * (first + last);
    // Normal equations for c₀ + c₁x + c₂x² about the middle.
    let power = |k: i32| points.iter().map(|(x, _)| (x - middle).powi(k)).sum::<f64>();
    let moment = |k: i32| points.iter().map(|(x, y)| y * (x - middle).powi(k)).sum::<f64>();
    let [s0, s1, s2, s3, s4] = [0, 1, 2, 3, 4].map(power);
    let [m0, m1, m2] = [0, 1, 2].map(moment);
    let c2 = determinant([[s0, s1, m0], [s1, s2, m1], [s2, s3, m2]]);
    let c1 = determinant([[s0, m0, s2], [s1, m1, s3], [s2, m2, s4]]);
    let at = middle - 0.5 * c1 / c2;
    let positive = determinant([[s0, s1, s2], [s1, s2, s3], [s2, s3, s4]]);
    (positive > 0.0 && c2 > 0.0 && (first..=last).contains(&at)).then_some(at)
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_kernel::{AddressedRandom, Channel, Seed};

    /// Errors that are least at `least`, alike in all runs but for their size.
    fn parabola(least: f64, lengths: &[f64]) -> Vec<Cell> {
        let square = |length: f64, run: u32| {
            (1.0 + 0.1 * f64::from(run)) * (0.3 * (length / least).ln().powi(2)).exp()
        };
        lengths.iter().map(|n| (*n, (0..5).map(|run| square(*n, run)).collect())).collect()
    }

    #[test]
    fn the_vertex_of_a_parabola_is_found_between_its_points() {
        let cells = parabola(62.0, &[40.0, 50.0, 70.0, 90.0]);
        for left_out in [None, Some(2)] {
            let found = vertex(&cells.iter().collect::<Vec<_>>(), left_out).unwrap().exp();
            assert!((found / 62.0 - 1.0).abs() < 1e-9, "{found}");
        }
        // Beyond the points, and upside down, there is none.
        for (least, lengths) in [(30.0, vec![40.0, 50.0, 70.0]), (62.0, vec![40.0, 50.0])] {
            let cells = parabola(least, &lengths);
            assert_eq!(vertex(&cells.iter().collect::<Vec<_>>(), None), None, "{lengths:?}");
        }
    }

    /// Over many campaigns of twenty runs the vertex scatters as the jackknife of each says.
    #[test]
    fn the_jackknife_knows_the_scatter_of_the_vertex() {
        let (runs, campaigns) = (20, 300);
        let campaign = |number: u64| -> Measured {
            let mut cells = parabola(62.0, &[40.0, 50.0, 70.0, 90.0]);
            for (k, (_, squares)) in cells.iter_mut().enumerate() {
                let at = 10 * number + k as u64;
                let mut random = AddressedRandom::new(Seed(1), Channel::NoiseTrial, at);
                let mean = squares[0];
                // Small beside the depth of the valley, so that no campaign loses the vertex.
                let scattered = |run| mean * (0.02 * random.standard_normal(run)).exp();
                *squares = (0..runs).map(scattered).collect();
            }
            of_valley(&cells.iter().collect::<Vec<_>>(), 20).unwrap()
        };
        let all: Vec<Measured> = (0..campaigns).map(campaign).collect();
        let mean_of =
            |of: &dyn Fn(&Measured) -> f64| all.iter().map(of).sum::<f64>() / campaigns as f64;
        let middle = mean_of(&|m| m.value.ln());
        let scatter = mean_of(&|m| (m.value.ln() - middle).powi(2)).sqrt();
        // Student's 2.093 for twenty runs.
        let claimed = mean_of(&|m| 0.5 * (m.high / m.low).ln() / 2.093);
        // Either is known to 1/sqrt(600), 4 %.
        assert!((claimed / scatter - 1.0).abs() < 0.15, "{claimed} for {scatter}");
    }

    #[test]
    fn a_flat_minimum_is_told_with_all_that_cannot_be_told_from_it() {
        // Ten lengths apart: two alike but for a scatter that is larger than their difference.
        let scattered = |mean: f64, phase: f64| -> Vec<f64> {
            (0..40).map(|run| mean + 0.2 * (phase * f64::from(run)).sin()).collect()
        };
        let cells = [
            (1.0, scattered(2.0, 0.3)),
            (10.0, scattered(1.0, 1.1)),
            (100.0, scattered(1.01, 1.7)),
            (1000.0, scattered(1.5, 2.3)),
        ];
        let found = alike(&cells, &cells[1]).unwrap();
        assert_eq!((found.value, found.low, found.high), (10.0, 10.0, 100.0));
    }
}
