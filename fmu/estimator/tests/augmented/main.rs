//! The five-state filter on the motion of the body model.
//!
//! Truth is closed-form torsion and random numbers by address. All runs are seeded.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod bound;
mod campaign;
mod rig;

use campaign::{Campaign, EPOCHS};
use rig::{A, B, C, D, E, Kicks, Scenario};

#[test]
fn table() {
    for (name, scenario) in [("A", A), ("B", B), ("C", C), ("D", D), ("E", E), ("A'", Scenario { rate_sigma_deg_s: 0.01, ..A}), ("B'", Scenario { rate_sigma_deg_s: 0.01, ..B}), ("C'", Scenario { rate_sigma_deg_s: 0.01, ..C}), ("D'", Scenario { rate_sigma_deg_s: 0.01, ..D}), ("E'", Scenario { rate_sigma_deg_s: 0.01, ..E})] {
        let c = Campaign::of(scenario);
        let b = bound::bound(scenario);
        println!(
            "{name}: h2 {:.4} ({:.3}) end {:.4} rate {:.5} ({:.3}; {:.5}) alarms {:.3} worst {:.2} nees {:?}",
            c.angle_deg(), c.angle_deg() / b.0, c.end_deg(), c.rate_deg_s(), c.rate_deg_s() / b.1, b.1,
            c.alarms(), c.worst_sigmas(), (0..EPOCHS).map(|k| (c.nees(k)*100.0).round()/100.0).collect::<Vec<_>>()
        );
    }
}

#[test]
fn kick_table() {
    for (size, over) in [(0.02, 0.0), (0.05, 0.0), (0.1, 0.0), (0.2, 0.0), (0.5,0.0), (1.0,0.0), (5.0,0.0), (0.02,1.0),(0.02,5.0),(0.05,5.0),(0.1,0.1),(0.1,1.0),(0.1,5.0),(0.5,0.1),(0.5,1.0),(0.5,5.0),(5.0,0.1),(5.0,1.0),(5.0,5.0)] {
        let c = Campaign::of(Scenario { kicks: Kicks::Ramp(size, over), ..B });
        let delays = c.delays_s();
        println!("{size} in {over}: h2 {:.3} end {:.3} rate {:.5} nees {:.2} worst {:.2} alarms {:.2} delay {:.2}/{:.2} found {}",
            c.angle_deg(), c.end_deg(), c.rate_deg_s(), c.nees(9), c.worst_sigmas(), c.alarms(), delays[delays.len()/2], delays[delays.len()*9/10], delays.len());
    }
}
