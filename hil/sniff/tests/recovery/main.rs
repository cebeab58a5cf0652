//! Random layouts recovered from their bytes.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod capture;
mod grade;
mod layouts;

use capture::{Conditions, capture, fresh};
use grade::{Grade, grade};
use layouts::random_sender;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

#[test]
fn draft() {
    let env = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let base = env("SEED", 0.0) as u64;
    let n = env("N", 100.0) as u64;
    let verbose = env("V", 0.0) > 0.0;
    for (corrupted, turned) in [(0.0, true), (0.001, true), (0.01, true), (0.0, false)] {
        let run = |from: u64| {
            let mut v = vec![];
            for seed in (base + from..base + n).step_by(2) {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let sender = random_sender(&mut rng);
                let bytes = capture(
                    &sender,
                    Conditions { seconds: env("SEC", 8.0), corrupted, turned },
                    &mut rng,
                );
                let (new, rates) = fresh(&sender.layout, 600, &mut rng);

                let t = std::time::Instant::now();
                let report = struna_sniff::sniff(&bytes, None);
                let guess = report.proposals.first().and_then(|p| p.layout()).cloned();
                let dt = t.elapsed().as_secs_f64();
                let g = guess
                    .as_ref()
                    .map_or(Grade::default(), |guess| grade(guess, &sender.layout, &new, &rates));
                if verbose && !g.is_functional() && (turned || env("V", 0.0) > 1.0) {
                    eprintln!(
                        "seed {seed} corr {corrupted} turned {turned} bytes {} status {:?}\n  {g:?}\n  TRUE {:?}\n  GUESS {:?}",
                        bytes.len(),
                        sender.status,
                        brief(&sender.layout),
                        guess.as_ref().map(brief)
                    );
                }
                v.push((g, dt, matches!(report.verdict, struna_sniff::Verdict::Confirmed { .. })));
            }
            v
        };
        let (a, b) = std::thread::scope(|s| {
            let h = s.spawn(|| run(0));
            let b = run(1);
            (h.join().unwrap(), b)
        });
        let all: Vec<_> = a.into_iter().chain(b).collect();
        let share = |f: &dyn Fn(&Grade) -> bool| {
            all.iter().filter(|(g, ..)| f(g)).count() as f64 / all.len() as f64
        };
        let mut t: Vec<f64> = all.iter().map(|x| x.1 * 1e3).collect();
        t.sort_by(f64::total_cmp);
        eprintln!(
            "corr {corrupted} turned {turned}: len {:.3} sync {:.3} counter {:.3} check {:.3} rate {:.3} FUNCTIONAL {:.4}  ms {:.0}/{:.0}/{:.0}",
            share(&|g| g.len),
            share(&|g| g.sync),
            share(&|g| g.counter),
            share(&|g| g.check),
            share(&|g| g.rate),
            share(&|g| g.is_functional()),
            t[t.len() / 2],
            t[t.len() * 95 / 100],
            t[t.len() - 1]
        );
        eprintln!(
            "corr confirmed {} of them wrong {}",
            all.iter().filter(|x| x.2).count(),
            all.iter().filter(|x| x.2 && !x.0.is_functional()).count()
        );
    }
}
fn brief(l: &struna_sniff::Layout) -> String {
    let mut s = format!(
        "len {} sync {:02x?} ctr {:?}",
        l.len,
        l.sync,
        l.counter.map(|c| (c.at, c.bytes, c.big_endian, c.modulus))
    );
    if let Some(c) = &l.check {
        s += &format!(
            " check {} {}..={} @{} be {}",
            match c.kind {
                struna_sniff::CheckKind::Crc(c) => c.name.to_string(),
                k => format!("{k:?}"),
            },
            c.first,
            c.last,
            c.at,
            c.big_endian
        );
    } else {
        s += " nocheck";
    }
    for f in &l.fields {
        s += &format!(
            " [{:?} @{} {}B {}b be {} {:?}]",
            f.role, f.at, f.bytes, f.bits, f.big_endian, f.coding
        );
    }
    s
}
