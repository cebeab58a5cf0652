//! Coefficients of the 8(5,3) Dormand-Prince pair with its dense output of order 7.
//!
//! Kept apart from the algorithm because they are published constants, each rounded once to the
//! nearest `f64`. Order conditions, tested below, would not survive a misprint.
//!
//! # Source
//! Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I*, second edition, 1993,
//! program `dop853`.

/// Stages of one step.
pub(super) const STAGES: usize = 12;
/// Stages known once a step is finished: its own, the derivative at its end, three for the
/// dense output.
pub(super) const STAGES_ALL: usize = 16;
/// Coefficient vectors of the dense output that come from [`D`] (order 7).
pub(super) const DENSE_ROWS: usize = 4;

/// Nodes: stage `i` is evaluated at `t + C[i]*h`.
pub(super) const C: [f64; STAGES_ALL] = [
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
    1.0,
    0.1,
    0.2,
    0.7777777777777778,
];

/// Stage weights: stage `i` starts from `y + h * sum_j A[i][j] k_j`.
pub(super) const A: [[f64; STAGES]; STAGES] = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.05260015195876773, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.0197250569845379, 0.0591751709536137, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.02958758547680685, 0.0, 0.08876275643042054, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [
        0.2413651341592667,
        0.0,
        -0.8845494793282861,
        0.924834003261792,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.037037037037037035,
        0.0,
        0.0,
        0.17082860872947386,
        0.12546768756682242,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.037109375,
        0.0,
        0.0,
        0.17025221101954405,
        0.06021653898045596,
        -0.017578125,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
        0.0,
        0.0,
        0.0,
    ],
    [
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
        0.0,
        0.0,
    ],
    [
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
        0.0,
    ],
];

/// Weights of the solution of order 8.
pub(super) const B: [f64; STAGES] = [
    0.054293734116568765,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    0.3111643669578199,
    -0.1521609496625161,
    0.20136540080403034,
    0.04471061572777259,
];

/// Stage weights of the three stages that only the dense output needs.
pub(super) const A_DENSE: [[f64; STAGES_ALL]; 3] = [
    [
        0.056167502283047954,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.25350021021662483,
        -0.2462390374708025,
        -0.12419142326381637,
        0.15329179827876568,
        0.00820105229563469,
        0.007567897660545699,
        -0.008298,
        0.0,
        0.0,
        0.0,
    ],
    [
        0.03183464816350214,
        0.0,
        0.0,
        0.0,
        0.0,
        0.028300909672366776,
        0.053541988307438566,
        -0.05492374857139099,
        0.0,
        0.0,
        -0.00010834732869724932,
        0.0003825710908356584,
        -0.00034046500868740456,
        0.1413124436746325,
        0.0,
        0.0,
    ],
    [
        -0.42889630158379194,
        0.0,
        0.0,
        0.0,
        0.0,
        -4.697621415361164,
        7.683421196062599,
        4.06898981839711,
        0.3567271874552811,
        0.0,
        0.0,
        0.0,
        -0.0013990241651590145,
        2.9475147891527724,
        -9.15095847217987,
        0.0,
    ],
];

/// Weights of the third-order error estimate.
pub(super) const E3: [f64; STAGES] = [
    -0.18980075407240762,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    -0.4226823213237919,
    -0.1521609496625161,
    0.20136540080403034,
    0.02265179219836082,
];

/// Weights of the fifth-order error estimate.
pub(super) const E5: [f64; STAGES] = [
    0.01312004499419488,
    0.0,
    0.0,
    0.0,
    0.0,
    -1.2251564463762044,
    -0.4957589496572502,
    1.6643771824549864,
    -0.35032884874997366,
    0.3341791187130175,
    0.08192320648511571,
    -0.022355307863886294,
];

/// Weights of the upper coefficient vectors of the dense output.
pub(super) const D: [[f64; STAGES_ALL]; DENSE_ROWS] = [
    [
        -8.428938276109013,
        0.0,
        0.0,
        0.0,
        0.0,
        0.5667149535193777,
        -3.0689499459498917,
        2.38466765651207,
        2.117034582445028,
        -0.871391583777973,
        2.2404374302607883,
        0.6315787787694688,
        -0.08899033645133331,
        18.148505520854727,
        -9.194632392478356,
        -4.436036387594894,
    ],
    [
        10.427508642579134,
        0.0,
        0.0,
        0.0,
        0.0,
        242.28349177525817,
        165.20045171727028,
        -374.5467547226902,
        -22.113666853125306,
        7.733432668472264,
        -30.674084731089398,
        -9.332130526430229,
        15.697238121770845,
        -31.139403219565178,
        -9.35292435884448,
        35.81684148639408,
    ],
    [
        19.985053242002433,
        0.0,
        0.0,
        0.0,
        0.0,
        -387.0373087493518,
        -189.17813819516758,
        527.8081592054236,
        -11.57390253995963,
        6.8812326946963,
        -1.0006050966910838,
        0.7777137798053443,
        -2.778205752353508,
        -60.19669523126412,
        84.32040550667716,
        11.99229113618279,
    ],
    [
        -25.69393346270375,
        0.0,
        0.0,
        0.0,
        0.0,
        -154.18974869023643,
        -231.5293791760455,
        357.6391179106141,
        93.40532418362432,
        -37.45832313645163,
        104.0996495089623,
        29.8402934266605,
        -43.53345659001114,
        96.32455395918828,
        -39.17726167561544,
        -149.72683625798564,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest deviation that rounding alone explains: terms up to 40, a dozen of them.
    const ROUNDING: f64 = 2e-13;

    #[test]
    fn every_stage_is_evaluated_where_its_weights_put_it() {
        for (row, node) in A.iter().zip(C) {
            assert!((row.iter().sum::<f64>() - node).abs() < ROUNDING, "node {node}");
        }
        for (row, node) in A_DENSE.iter().zip(&C[STAGES + 1..]) {
            assert!((row.iter().sum::<f64>() - node).abs() < ROUNDING, "node {node}");
        }
    }

    #[test]
    fn no_stage_depends_on_a_later_one() {
        for (i, row) in A.iter().enumerate() {
            assert!(row[i..].iter().all(|a| *a == 0.0), "stage {i}");
        }
        for (i, row) in A_DENSE.iter().enumerate() {
            assert!(row[STAGES + 1 + i..].iter().all(|a| *a == 0.0), "dense stage {i}");
        }
    }

    #[test]
    fn the_weights_integrate_polynomials_up_to_degree_seven() {
        for degree in 0..8_i32 {
            let sum: f64 = B.iter().zip(C).map(|(b, c)| b * c.powi(degree)).sum();
            let exact = 1.0 / f64::from(degree + 1);
            assert!((sum - exact).abs() < ROUNDING, "degree {degree}: {sum}");
        }
    }

    #[test]
    fn the_weights_integrate_nested_polynomials_up_to_order_eight() {
        // Trees with one branch: sum_i b_i c_i^m sum_j a_ij c_j^n = 1/((n+1)(m+n+2)).
        for m in 0..7_i32 {
            for n in 1..(7 - m) {
                let inner =
                    |row: &[f64]| -> f64 { row.iter().zip(C).map(|(a, c)| a * c.powi(n)).sum() };
                let sum: f64 =
                    B.iter().zip(C).zip(&A).map(|((b, c), row)| b * c.powi(m) * inner(row)).sum();
                let exact = 1.0 / (f64::from(n + 1) * f64::from(m + n + 2));
                assert!((sum - exact).abs() < ROUNDING, "m {m}, n {n}: {sum}");
            }
        }
    }

    #[test]
    fn the_error_weights_see_nothing_below_their_order() {
        for (weights, order) in [(&E3, 3_i32), (&E5, 5)] {
            for degree in 0..order {
                let sum: f64 = weights.iter().zip(C).map(|(e, c)| e * c.powi(degree)).sum();
                assert!(sum.abs() < ROUNDING, "order {order}, degree {degree}: {sum}");
            }
            let next: f64 = weights.iter().zip(C).map(|(e, c)| e * c.powi(order)).sum();
            assert!(next.abs() > 1e-4, "an estimate of order {order} must see degree {order}");
        }
    }
}
