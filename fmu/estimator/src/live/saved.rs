//! The whole estimator as plain bytes, a running fit included.

use super::doubt::Doubt;
use super::estimator::{Clock, LiveEstimator, Phase};
use super::eye::SwingEye;
use super::pursuit::{Beginning, Pursuit};
use super::tape::Anchors;
use crate::RateEstimator;
use crate::state_bytes::{Reader, RestoreError, Writer};

/// Numbers of the phases in saved bytes.
const TORSION: u64 = 0;
const FITTING: u64 = 1;
const SWINGING: u64 = 2;
const UNSEEN: u64 = 3;

impl Clock {
    const SAVED_LEN: usize = 10 * 8;

    fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.since_update_s);
        out.f64(self.over_range_s);
        out.f64(self.away_s);
        out.f64(self.yields_s);
        out.u64(u64::from(self.yields));
        out.u64(u64::from(self.doubts));
        out.f64(self.torsion_s);
        out.u64(self.answered);
        out.f64(self.quiet_s);
        out.f64(self.lead);
    }

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let clock = Self {
            since_update_s: bytes.finite("since_update_s")?,
            over_range_s: bytes.finite("over_range_s")?,
            away_s: bytes.finite("away_s")?,
            yields_s: bytes.finite("yields_s")?,
            yields: bytes.u64() != 0,
            doubts: bytes.u64() != 0,
            torsion_s: bytes.finite("torsion_s")?,
            answered: bytes.u64(),
            quiet_s: bytes.finite("quiet_s")?,
            lead: bytes.finite("lead")?,
        };
        let Self { since_update_s, over_range_s, away_s, yields_s, torsion_s, quiet_s, .. } = clock;
        let times = [since_update_s, over_range_s, away_s, yields_s, torsion_s, quiet_s];
        let possible = times.iter().all(|time_s| *time_s >= 0.0);
        if possible { Ok(clock) } else { Err(RestoreError::Impossible) }
    }
}

impl Phase {
    fn number(&self) -> u64 {
        match self {
            Self::Torsion => TORSION,
            Self::Fitting(_) => FITTING,
            Self::Swinging(_) => SWINGING,
            Self::Unseen => UNSEEN,
        }
    }
}

/// The first `len` bytes of `rest`, which then begins behind them.
fn section<'a>(rest: &mut &'a mut [u8], len: usize) -> &'a mut [u8] {
    let (head, tail) = core::mem::take(rest).split_at_mut(len);
    *rest = tail;
    head
}

/// The same of bytes that are read.
fn taken<'a>(rest: &mut &'a [u8], len: usize) -> &'a [u8] {
    let (head, tail) = rest.split_at(len);
    *rest = tail;
    head
}

impl LiveEstimator {
    /// Length of what is of the switch itself.
    fn own_len(&self) -> usize {
        8 + Clock::SAVED_LEN
            + SwingEye::SAVED_LEN
            + self.tape.saved_len()
            + Anchors::SAVED_LEN
            + Doubt::SAVED_LEN
            + Pursuit::SAVED_LEN
    }

    pub(super) fn whole_len(&self) -> usize {
        let filters = [self.torsion.saved_len(), self.bank.saved_len(), self.fallback.saved_len()];
        self.own_len() + filters.iter().sum::<usize>() + self.swing_len
    }

    pub(super) fn write_all(&self, out: &mut [u8]) {
        let mut rest = out;
        self.torsion.save(section(&mut rest, self.torsion.saved_len()));
        self.bank.save(section(&mut rest, self.bank.saved_len()));
        self.fallback.save(section(&mut rest, self.fallback.saved_len()));
        let swing = section(&mut rest, self.swing_len);
        match &self.phase {
            Phase::Swinging(filter) => filter.save(swing),
            _ => swing.fill(0),
        }
        let own = section(&mut rest, self.own_len());
        own.fill(0);
        let mut out = Writer::new(own);
        out.u64(self.phase.number());
        self.clock.write(&mut out);
        self.eye.write(&mut out);
        self.tape.write(&mut out);
        self.anchors.write(&mut out);
        self.doubt.write(&mut out);
        if let Phase::Fitting(pursuit) = &self.phase {
            pursuit.write(&mut out);
        }
    }

    /// Reads everything before it takes over anything.
    pub(super) fn read_all(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut rest = bytes;
        let mut torsion = self.torsion.clone();
        torsion.restore(taken(&mut rest, torsion.saved_len()))?;
        let mut bank = self.bank.clone();
        bank.restore(taken(&mut rest, bank.saved_len()))?;
        let mut fallback = self.fallback.clone();
        fallback.restore(taken(&mut rest, fallback.saved_len()))?;
        let swing = taken(&mut rest, self.swing_len);
        let mut own = Reader::new(rest, self.own_len())?;
        let number = own.u64();
        let clock = Clock::read(&mut own)?;
        let eye = self.eye.read(&mut own)?;
        let mut tape = self.tape.clone();
        tape.read(&mut own)?;
        let anchors = Anchors::read(&mut own)?;
        let doubt = Doubt::read(&mut own)?;
        let spares = self.setup.new_spares(self.eye.sight());
        let mut spares = spares.map_err(|_| RestoreError::Impossible)?;
        let phase = match number {
            TORSION => Phase::Torsion,
            UNSEEN => Phase::Unseen,
            SWINGING => {
                let mut filter = spares.filter.take().ok_or(RestoreError::Impossible)?;
                filter.restore(swing)?;
                Phase::Swinging(filter)
            }
            FITTING => {
                let mut pursuit = spares.pursuit.take().ok_or(RestoreError::Impossible)?;
                let beginning = Beginning::read(&mut own)?;
                beginning.again(&mut pursuit, &tape, &mut spares.filter)?;
                Phase::Fitting(pursuit)
            }
            _ => return Err(RestoreError::Impossible),
        };
        (self.torsion, self.bank, self.fallback) = (torsion, bank, fallback);
        (self.clock, self.eye, self.tape) = (clock, eye, tape);
        (self.anchors, self.phase, self.doubt, self.spares) = (anchors, phase, doubt, spares);
        Ok(())
    }
}
