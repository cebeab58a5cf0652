//! The covariance of the plain two-state filter in several forms, in either precision.
//!
//! The filter's gain and covariance do not depend on what is measured, so the covariance alone is
//! carried along: P = (a, b; b, c), measured is the rate, H = (0 1).

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};
use struna_estimator::Transition;

/// f64 or f32.
pub(crate) trait Real:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    const ONE: Self;
    const EPSILON: f64;
    fn of(value: f64) -> Self;
    fn wide(self) -> f64;
}

impl Real for f64 {
    const ONE: Self = 1.0;
    const EPSILON: f64 = Self::EPSILON;
    fn of(value: f64) -> Self {
        value
    }
    fn wide(self) -> f64 {
        self
    }
}

impl Real for f32 {
    const ONE: Self = 1.0;
    const EPSILON: f64 = Self::EPSILON as f64;
    #[expect(clippy::cast_possible_truncation, reason = "single precision is what is looked at")]
    fn of(value: f64) -> Self {
        value as Self
    }
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

/// Transition over a step, process noise over it and R, rounded to the precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Model<T> {
    pub(crate) f11: T,
    pub(crate) f12: T,
    pub(crate) f21: T,
    pub(crate) f22: T,
    /// f11 − 1 and f22 − 1, which are the same, before they were rounded.
    pub(crate) less: T,
    pub(crate) q11: T,
    pub(crate) q12: T,
    pub(crate) q22: T,
    /// q12/q22 and q11 − q12²/q22: the noise as U·D·Uᵀ.
    pub(crate) noise_u: T,
    pub(crate) noise_d1: T,
    pub(crate) r: T,
}

impl<T: Real> Model<T> {
    /// `less` is cos Ωh − 1 = −2·sin²(Ωh/2).
    pub(crate) fn new(t: &Transition, less: f64, q: f64, r: f64) -> Self {
        Self {
            f11: T::of(t.f11),
            f12: T::of(t.f12),
            f21: T::of(t.f21),
            f22: T::of(t.f22),
            less: T::of(less),
            q11: T::of(q * t.q11),
            q12: T::of(q * t.q12),
            q22: T::of(q * t.q22),
            noise_u: T::of(t.q12 / t.q22),
            noise_d1: T::of(q * (t.q11 - t.q12 * t.q12 / t.q22)),
            r: T::of(r),
        }
    }
}

/// A way of carrying the covariance.
pub(crate) trait Form<T: Real> {
    const NAME: &'static str;
    /// With independent variances of angle and rate.
    fn start(angle: T, rate: T) -> Self;
    fn step(&mut self, model: &Model<T>);
    /// (a, b above, b below, c).
    fn matrix(&self) -> [f64; 4];

    /// Whether the symmetric part has no negative eigenvalue, as far as three numbers of the
    /// precision can tell: with angle and rate all but certain to go together, the last digit of
    /// any of the three decides the determinant's sign.
    fn is_positive(&self) -> bool {
        let [a, above, below, c] = self.matrix();
        let b = 0.5 * (above + below);
        a > 0.0 && c > 0.0 && a * c - b * b >= -4.0 * T::EPSILON * a * c
    }

    /// How far the off-diagonals are apart, as a share of √(a·c).
    fn asymmetry(&self) -> f64 {
        let [a, above, below, c] = self.matrix();
        (above - below).abs() / (a * c).abs().sqrt()
    }
}

/// P⁺ = (I − K·H)·P, four numbers: as in the textbooks.
pub(crate) struct Standard<T> {
    a: T,
    above: T,
    below: T,
    c: T,
}

impl<T: Real> Form<T> for Standard<T> {
    const NAME: &'static str = "standard";

    fn start(angle: T, rate: T) -> Self {
        let zero = T::of(0.0);
        Self { a: angle, above: zero, below: zero, c: rate }
    }

    fn step(&mut self, m: &Model<T>) {
        let Self { a, above, below, c } = *self;
        // Φ·P, then ·Φᵀ + Q.
        let (ta, tb) = (m.f11 * a + m.f12 * below, m.f11 * above + m.f12 * c);
        let (ra, rb) = (m.f21 * a + m.f22 * below, m.f21 * above + m.f22 * c);
        let a = ta * m.f11 + tb * m.f12 + m.q11;
        let above = ta * m.f21 + tb * m.f22 + m.q12;
        let below = ra * m.f11 + rb * m.f12 + m.q12;
        let c = ra * m.f21 + rb * m.f22 + m.q22;
        let s = c + m.r;
        let (k1, k2) = (above / s, c / s);
        let keep = T::ONE - k2;
        *self = Self { a: a - k1 * below, above: above - k1 * c, below: keep * below, c: keep * c };
    }

    fn matrix(&self) -> [f64; 4] {
        [self.a, self.above, self.below, self.c].map(T::wide)
    }
}

/// P⁺ = (R/S)·P + (det P/S)·(1 0)ᵀ(1 0), three numbers: operation for operation the filter's.
pub(crate) struct Scaled<T> {
    a: T,
    b: T,
    c: T,
}

impl<T: Real> Form<T> for Scaled<T> {
    const NAME: &'static str = "scaled";

    fn start(angle: T, rate: T) -> Self {
        Self { a: angle, b: T::of(0.0), c: rate }
    }

    fn step(&mut self, m: &Model<T>) {
        let Self { a, b, c } = *self;
        let [a, b, c] = [
            [m.f11 * m.f11, T::of(2.0) * m.f11 * m.f12, m.f12 * m.f12, m.q11],
            [m.f11 * m.f21, m.f11 * m.f22 + m.f12 * m.f21, m.f12 * m.f22, m.q12],
            [m.f21 * m.f21, T::of(2.0) * m.f21 * m.f22, m.f22 * m.f22, m.q22],
        ]
        .map(|by| (by[2] * c + by[3]) + (by[1] * b + by[0] * a));
        let determinant = a * c - b * b;
        let zero = T::of(0.0);
        let determinant = if zero > determinant { zero } else { determinant };
        let inverse = T::ONE / (c + m.r);
        *self = Self {
            a: (a * m.r + determinant) * inverse,
            b: b * m.r * inverse,
            c: c * m.r * inverse,
        };
    }

    fn matrix(&self) -> [f64; 4] {
        [self.a, self.b, self.b, self.c].map(T::wide)
    }
}

/// P⁺ = (I − K·H)·P·(I − K·H)ᵀ + K·R·Kᵀ, three numbers.
pub(crate) struct Joseph<T> {
    a: T,
    b: T,
    c: T,
}

impl<T: Real> Joseph<T> {
    fn updated(a: T, b: T, c: T, r: T) -> Self {
        let inverse = T::ONE / (c + r);
        let (k1, k2) = (b * inverse, c * inverse);
        let (mixed, keep) = (b - k1 * c, T::ONE - k2);
        Self {
            a: (a - k1 * b) - k1 * mixed + k1 * r * k1,
            b: mixed * keep + k1 * r * k2,
            c: keep * c * keep + k2 * r * k2,
        }
    }
}

impl<T: Real> Form<T> for Joseph<T> {
    const NAME: &'static str = "Joseph";

    fn start(angle: T, rate: T) -> Self {
        Self { a: angle, b: T::of(0.0), c: rate }
    }

    fn step(&mut self, m: &Model<T>) {
        let Self { a, b, c } = *self;
        let (ta, tb) = (m.f11 * a + m.f12 * b, m.f11 * b + m.f12 * c);
        let (ra, rb) = (m.f21 * a + m.f22 * b, m.f21 * b + m.f22 * c);
        *self = Self::updated(
            ta * m.f11 + tb * m.f12 + m.q11,
            ta * m.f21 + tb * m.f22 + m.q12,
            ra * m.f21 + rb * m.f22 + m.q22,
            m.r,
        );
    }

    fn matrix(&self) -> [f64; 4] {
        [self.a, self.b, self.b, self.c].map(T::wide)
    }
}

/// What a prediction adds to (a, b, c): with E = Φ − I it is E·P + (E·P)ᵀ + E·P·Eᵀ + Q.
fn increments<T: Real>([a, b, c]: [T; 3], m: &Model<T>) -> [T; 3] {
    let (ta, tb) = (m.less * a + m.f12 * b, m.less * b + m.f12 * c);
    let (ra, rb) = (m.f21 * a + m.less * b, m.f21 * b + m.less * c);
    [
        ta + ta + ta * m.less + tb * m.f12 + m.q11,
        tb + ra + ta * m.f21 + tb * m.less + m.q12,
        rb + rb + ra * m.f21 + rb * m.less + m.q22,
    ]
}

/// Joseph's form with P⁻ = P + (what changes), in which cos Ωh − 1 stands by itself.
pub(crate) struct Incremental<T>(Joseph<T>);

impl<T: Real> Form<T> for Incremental<T> {
    const NAME: &'static str = "Joseph by increments";

    fn start(angle: T, rate: T) -> Self {
        Self(Joseph::start(angle, rate))
    }

    fn step(&mut self, m: &Model<T>) {
        let Joseph { a, b, c } = self.0;
        let grown = increments([a, b, c], m);
        self.0 = Joseph::updated(a + grown[0], b + grown[1], c + grown[2], m.r);
    }

    fn matrix(&self) -> [f64; 4] {
        self.0.matrix()
    }
}

/// P ← P + (all that a step changes), with what the sum rounds off carried to the next.
///
/// # Source
/// Neumaier, *Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen*, 1974.
pub(crate) struct Compensated<T> {
    p: [T; 3],
    lost: [T; 3],
}

/// (sum, what it lacks).
fn two_sum<T: Real>(x: T, y: T) -> (T, T) {
    let sum = x + y;
    let of_y = sum - x;
    (sum, (x - (sum - of_y)) + (y - of_y))
}

impl<T: Real> Form<T> for Compensated<T> {
    const NAME: &'static str = "increments, compensated";

    fn start(angle: T, rate: T) -> Self {
        let zero = T::of(0.0);
        Self { p: [angle, zero, rate], lost: [zero; 3] }
    }

    fn step(&mut self, m: &Model<T>) {
        let [a, b, c] = self.p;
        let grown = increments([a, b, c], m);
        let (b, c) = (b + grown[1], c + grown[2]);
        let s = c + m.r;
        let changes = [grown[0] - b / s * b, grown[1] - c / s * b, grown[2] - c / s * c];
        for ((p, lost), change) in self.p.iter_mut().zip(&mut self.lost).zip(changes) {
            (*p, *lost) = two_sum(*p, change + *lost);
        }
    }

    fn matrix(&self) -> [f64; 4] {
        let [a, b, c] = self.p;
        [a, b, b, c].map(T::wide)
    }
}

/// P = U·D·Uᵀ with U = (1, u; 0, 1): positive as long as D is, and D is never subtracted from.
///
/// # Source
/// Bierman, *Factorization Methods for Discrete Sequential Estimation*, 1977; time update by
/// Thornton's weighted Gram-Schmidt.
pub(crate) struct Factored<T> {
    u: T,
    d1: T,
    d2: T,
}

impl<T: Real> Form<T> for Factored<T> {
    const NAME: &'static str = "UD";

    fn start(angle: T, rate: T) -> Self {
        Self { u: T::of(0.0), d1: angle, d2: rate }
    }

    fn step(&mut self, m: &Model<T>) {
        let Self { u, d1, d2 } = *self;
        // Rows of (Φ·U, U of the noise), orthogonalised with weights (d1, d2, noise_d1, q22).
        let angle = [m.f11, m.f11 * u + m.f12];
        let rate = [m.f21, m.f21 * u + m.f22];
        let c = rate[0] * rate[0] * d1 + rate[1] * rate[1] * d2 + m.q22;
        let b = angle[0] * rate[0] * d1 + angle[1] * rate[1] * d2 + m.noise_u * m.q22;
        let u = b / c;
        let rest = [angle[0] - u * rate[0], angle[1] - u * rate[1], m.noise_u - u];
        let d1 = rest[0] * rest[0] * d1
            + rest[1] * rest[1] * d2
            + rest[2] * rest[2] * m.q22
            + m.noise_d1;
        // A measured rate touches D alone.
        *self = Self { u, d1, d2: c * m.r / (c + m.r) };
    }

    fn matrix(&self) -> [f64; 4] {
        let [u, d1, d2] = [self.u, self.d1, self.d2].map(T::wide);
        [d1 + u * u * d2, u * d2, u * d2, d2]
    }

    /// The product that [`matrix`](Self::matrix) makes of it may round; the factors do not.
    fn is_positive(&self) -> bool {
        self.d1.wide() > 0.0 && self.d2.wide() > 0.0
    }
}
