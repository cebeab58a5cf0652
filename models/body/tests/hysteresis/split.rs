//! One-dimensional torsion of a yielding thread, split at its events: the independent reference.
//!
//! Nothing here is shared with the library. Between two events the direction of motion and the
//! elements that slip are fixed, so every strain is a smooth function of the turn alone and the
//! classical Runge-Kutta method keeps its order 4. Events are located by bisection.

/// One element: stiffness over moment of inertia, 1/s², and yield strain, rad.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    pub(crate) stiffness_s2: f64,
    pub(crate) yield_rad: f64,
}

/// τ″ = −Ω²τ − Σ κᵢzᵢ.
#[derive(Debug, Clone)]
pub(crate) struct Yielding {
    pub(crate) stiffness_s2: f64,
    /// Dahl's law if true, Maxwell-slip if not.
    pub(crate) dahl: bool,
    pub(crate) elements: Vec<Element>,
}

/// Where a run ended, and the turning points on the way.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) turn_rad: f64,
    /// Reversals and yields passed.
    pub(crate) events: usize,
    /// Turns at which the motion reversed, rad.
    pub(crate) reversals_rad: Vec<f64>,
}

/// The motion between two events.
struct Piece<'a> {
    torsion: &'a Yielding,
    direction: f64,
    /// Turn and strains where the piece began.
    turn_rad: f64,
    strain_rad: Vec<f64>,
    slips: Vec<bool>,
}

enum Event {
    Reversal,
    Yield(usize),
}

impl Yielding {
    /// Runs from rest, relaxed, at `start_rad` for `steps` steps of `step_s`.
    pub(crate) fn run(&self, start_rad: f64, step_s: f64, steps: u32) -> Run {
        let count = self.elements.len();
        let mut piece = Piece {
            torsion: self,
            direction: -start_rad.signum(),
            turn_rad: start_rad,
            strain_rad: vec![0.0; count],
            slips: vec![false; count],
        };
        let mut state = [start_rad, 0.0];
        let mut run = Run { turn_rad: start_rad, events: 0, reversals_rad: Vec::new() };
        for _ in 0..steps {
            let mut rest_s = step_s;
            while rest_s > 0.0 {
                let end = piece.step(state, rest_s);
                let Some(event) = piece.event(end) else {
                    state = end;
                    break;
                };
                let (taken_s, end, event) = piece.located(state, rest_s, event);
                (state, rest_s, run.events) = (end, rest_s - taken_s, run.events + 1);
                if let Event::Reversal = event {
                    run.reversals_rad.push(state[0]);
                }
                piece.pass(state, &event);
            }
        }
        run.turn_rad = state[0];
        run
    }
}

impl Piece<'_> {
    fn strain(&self, i: usize, turn_rad: f64) -> f64 {
        let (limit, change) = (self.torsion.elements[i].yield_rad, turn_rad - self.turn_rad);
        let end = self.direction * limit;
        if self.torsion.dahl {
            end + (self.strain_rad[i] - end) * (-self.direction * change / limit).exp()
        } else if self.slips[i] {
            end
        } else {
            self.strain_rad[i] + change
        }
    }

    fn rate(&self, [turn, rate]: [f64; 2]) -> [f64; 2] {
        let t = self.torsion;
        let yielding: f64 =
            t.elements.iter().enumerate().map(|(i, e)| e.stiffness_s2 * self.strain(i, turn)).sum();
        [rate, -t.stiffness_s2 * turn - yielding]
    }

    fn step(&self, y: [f64; 2], h: f64) -> [f64; 2] {
        let moved = |h: f64, k: [f64; 2]| [y[0] + h * k[0], y[1] + h * k[1]];
        let k1 = self.rate(y);
        let k2 = self.rate(moved(0.5 * h, k1));
        let k3 = self.rate(moved(0.5 * h, k2));
        let k4 = self.rate(moved(h, k3));
        let sum = |i: usize| k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i];
        [y[0] + h / 6.0 * sum(0), y[1] + h / 6.0 * sum(1)]
    }

    /// What has happened by the state `y` that ends this piece.
    fn event(&self, y: [f64; 2]) -> Option<Event> {
        if y[1] * self.direction < 0.0 {
            return Some(Event::Reversal);
        }
        let yields = |i: usize| {
            let past = self.direction * self.strain(i, y[0]) > self.torsion.elements[i].yield_rad;
            !self.torsion.dahl && !self.slips[i] && past
        };
        (0..self.strain_rad.len()).find(|i| yields(*i)).map(Event::Yield)
    }

    /// The first event within a step: when, the state just after it, and which it is.
    fn located(&self, y: [f64; 2], step_s: f64, event: Event) -> (f64, [f64; 2], Event) {
        let (mut before_s, mut after_s, mut first) = (0.0, step_s, event);
        while after_s - before_s > 1e-13 * step_s {
            let middle_s = 0.5 * (before_s + after_s);
            match self.event(self.step(y, middle_s)) {
                Some(event) => (after_s, first) = (middle_s, event),
                None => before_s = middle_s,
            }
        }
        (after_s, self.step(y, after_s), first)
    }

    /// Begins the next piece at `y`.
    fn pass(&mut self, y: [f64; 2], event: &Event) {
        let strains = (0..self.strain_rad.len()).map(|i| self.strain(i, y[0])).collect();
        (self.turn_rad, self.strain_rad) = (y[0], strains);
        match *event {
            Event::Reversal => {
                self.direction = -self.direction;
                self.slips.fill(false);
            }
            Event::Yield(i) => self.slips[i] = true,
        }
    }
}
