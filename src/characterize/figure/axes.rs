//! Two logarithmic axes, laid out in pixels.

use super::super::unit::significant;

/// Pixels of the frame: left, top, right, bottom.
pub(super) const FRAME: [i32; 4] = [96, 104, 900, 720];

/// Decades per axis below which 2 and 5 are labelled, too.
const FEW_DECADES: f64 = 2.5;

/// The frame with the decades that it shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    /// log10 of τ in s at left and right.
    x: [f64; 2],
    /// log10 of the deviation in °/h at bottom and top.
    y: [f64; 2],
}

/// A line of the grid.
pub(super) struct Tick {
    pub at: i32,
    /// A decade, drawn stronger.
    pub is_decade: bool,
    pub label: Option<String>,
}

impl Axes {
    /// Axes around positive ranges, with a margin.
    pub(super) fn around(taus_s: [f64; 2], deviations: [f64; 2]) -> Self {
        let widened = |[low, high]: [f64; 2], margin: f64| {
            let (low, high) = (low.log10(), high.log10());
            // A flat curve needs some height to be flat in.
            let short = (0.5 - 0.5 * (high - low)).max(0.0);
            [low - margin - short, high + margin + short]
        };
        Self { x: widened(taus_s, 0.08), y: widened(deviations, 0.15) }
    }

    pub(super) fn x(&self, tau_s: f64) -> i32 {
        let [left, _, right, _] = FRAME;
        place(tau_s.log10(), self.x, [left, right])
    }

    pub(super) fn y(&self, deviation: f64) -> i32 {
        let [_, top, _, bottom] = FRAME;
        place(deviation.log10(), self.y, [bottom, top])
    }

    /// A point, moved to the edge of the frame where it lies beyond.
    pub(super) fn at(&self, tau_s: f64, deviation: f64) -> (i32, i32) {
        let [left, top, right, bottom] = FRAME;
        (self.x(tau_s).clamp(left, right), self.y(deviation).clamp(top, bottom))
    }

    /// The two ends of a straight slope, `deviation` at `tau_s`, within the frame.
    pub(super) fn slope(&self, tau_s: f64, deviation: f64, slope: f64) -> Option<[(f64, f64); 2]> {
        let (x, y) = (tau_s.log10(), deviation.log10());
        let [mut from, mut to] = self.x;
        if slope != 0.0 {
            let at_edge = self.y.map(|edge| x + (edge - y) / slope);
            from = from.max(at_edge[0].min(at_edge[1]));
            to = to.min(at_edge[0].max(at_edge[1]));
        } else if y < self.y[0] || y > self.y[1] {
            return None;
        }
        let end = |at: f64| (10.0_f64.powf(at), 10.0_f64.powf(y + slope * (at - x)));
        (from < to).then(|| [end(from), end(to)])
    }

    pub(super) fn x_ticks(&self) -> Vec<Tick> {
        ticks(self.x, |tau_s| self.x(tau_s))
    }

    pub(super) fn y_ticks(&self) -> Vec<Tick> {
        ticks(self.y, |deviation| self.y(deviation))
    }
}

fn place(value: f64, [from, to]: [f64; 2], [first, last]: [i32; 2]) -> i32 {
    let share = ((value - from) / (to - from)).clamp(-10.0, 10.0);
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    let pixels = (f64::from(last - first) * share).round() as i32;
    first + pixels
}

fn ticks(range: [f64; 2], place: impl Fn(f64) -> i32) -> Vec<Tick> {
    #[expect(clippy::cast_possible_truncation, reason = "a logarithm of a float")]
    let decades = range[0].floor() as i32..=range[1].floor() as i32;
    let few = range[1] - range[0] < FEW_DECADES;
    let lines = decades.flat_map(|decade| (1..10).map(move |digit| (decade, digit)));
    lines
        .map(|(decade, digit)| (digit, f64::from(digit) * 10.0_f64.powi(decade)))
        .filter(|(_, value)| (range[0]..=range[1]).contains(&value.log10()))
        .map(|(digit, value)| Tick {
            at: place(value),
            is_decade: digit == 1,
            label: (digit == 1 || (few && [2, 5].contains(&digit))).then(|| label(value)),
        })
        .collect()
}

fn label(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        let text = format!("{value:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    significant(value, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_evenly_spaced_and_labelled() {
        let axes = Axes::around([0.01, 100.0], [1.0, 1000.0]);
        let labelled: Vec<_> = axes.x_ticks().into_iter().filter(|t| t.label.is_some()).collect();
        let labels: Vec<_> = labelled.iter().map(|tick| tick.label.clone().unwrap()).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
        let steps: Vec<_> = labelled.windows(2).map(|pair| pair[1].at - pair[0].at).collect();
        assert!(steps.iter().all(|step| (step - steps[0]).abs() <= 1), "{steps:?}");
        assert!(axes.y_ticks().len() > 20);
    }

    #[test]
    fn slopes_end_at_the_frame() {
        let axes = Axes::around([1.0, 100.0], [1.0, 10.0]);
        let [left, top, right, bottom] = FRAME;
        for slope in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let [from, to] = axes.slope(10.0, 3.0, slope).unwrap();
            for (tau_s, deviation) in [from, to] {
                let (x, y) = (axes.x(tau_s), axes.y(deviation));
                assert!((left..=right).contains(&x) && (top..=bottom).contains(&y), "{slope}");
                assert!([left, right].contains(&x) || [top, bottom].contains(&y), "{slope}");
            }
        }
        assert!(axes.slope(10.0, 1e-9, 0.0).is_none());
        assert!(axes.slope(10.0, 1e-9, -0.5).is_none());
    }
}
