//! Says what the found numbers are: which one is the rate, how it is coded, what the rest may be.

use crate::field::{self, Window};
use crate::frames::Frames;
use crate::layout::{Coding, Field, Role};
use crate::length::{as_f64, as_float};
use crate::motion::{Motion, REST_EXCURSION, median, spread};

/// Frames from which ranges are judged.
const SAMPLES: usize = 4096;

/// A number with the way it moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moved {
    pub(crate) field: Field,
    pub(crate) motion: Motion,
    /// Sample-to-sample noise as a share of full scale.
    noise: f64,
}

impl Moved {
    /// Lowest bytes that show nothing but noise: its steps are many times what they can tell.
    pub(crate) fn noisy_bytes(&self) -> usize {
        let steps = self.noise * f64::from(self.field.bits).exp2();
        let whole =
            |bytes: &usize| steps > 8.0 * f64::from(8 * u32::try_from(*bytes).unwrap_or(4)).exp2();
        if self.field.coding == Coding::Float { 0 } else { (1..3).take_while(whole).count() }
    }
}

/// Names every window; the rate is the field that moves most, at rest the noisiest.
pub(crate) fn name_fields(frames: &Frames<'_>, windows: &[Window]) -> Vec<Moved> {
    let mut moved: Vec<Moved> = windows.iter().map(|window| measure(frames, *window)).collect();
    let Some(rate) = rate_among(&moved) else { return moved };
    moved[rate].field.role = Role::Rate;
    if let Some(channel) = channel_word(frames, &mut moved[rate]) {
        moved.push(channel);
    }
    let mut temperature_named = false;
    for field in moved.iter_mut().map(|moved| &mut moved.field) {
        if field.role != Role::Unknown {
            continue;
        }
        // Slow numbers show too little of their range to tell how many bits they own.
        field.bits = whole_bits(frames, field.bytes);
        match field.bytes {
            1 => (field.role, field.coding) = (Role::Status, Coding::Unsigned),
            2 if !temperature_named => {
                (field.role, field.coding) = (Role::Temperature, Coding::Twos);
                temperature_named = true;
            }
            _ => {}
        }
    }
    moved
}

fn rate_among(moved: &[Moved]) -> Option<usize> {
    let wide = |moved: &Moved| moved.field.bytes > 1;
    let most = |key: fn(&Moved) -> f64| {
        let ranked = (0..moved.len()).filter(|k| wide(&moved[*k]));
        ranked.max_by(|a, b| key(&moved[*a]).total_cmp(&key(&moved[*b])).then(b.cmp(a)))
    };
    let fastest = most(|moved| moved.motion.excursion)?;
    if moved[fastest].motion.excursion >= REST_EXCURSION {
        Some(fastest)
    } else {
        most(|m| m.noise)
    }
}

fn sampled(frames: &Frames<'_>) -> impl Iterator<Item = usize> {
    let count = frames.count().min(SAMPLES);
    (0..count).map(move |k| frames.starts[k * frames.count() / count])
}

fn measure(frames: &Frames<'_>, window: Window) -> Moved {
    let Window { at, bytes, big_endian } = window;
    let whole = whole_bits(frames, bytes);
    let codes: Vec<u64> =
        sampled(frames).map(|start| frames.number(start, at, bytes, big_endian)).collect();
    let bits = bits_in_use(frames, &codes, whole);
    let mut field = Field {
        role: Role::Unknown,
        at,
        bytes,
        bits,
        shift: 0,
        big_endian,
        coding: Coding::Unsigned,
        only_channel_zero: false,
    };
    if is_float(frames, window) {
        field.coding = Coding::Float;
        let (motion, noise) = float_motion(frames, window);
        return Moved { field, motion, noise };
    }
    field.coding = coding_of(&codes, bits);
    let full = f64::from(bits).exp2();
    let raw = |start| raw_float(field.raw(frames.frame(start), frames.digit_bits));
    let values: Vec<f64> = sampled(frames).map(raw).collect();
    let noise = noise_of(frames, &field) / full;
    Moved { field, motion: Motion::of(&values, full), noise }
}

fn is_float(frames: &Frames<'_>, window: Window) -> bool {
    window.bytes == 4
        && frames.digit_bits == 8
        && field::is_float(frames, window.at, window.big_endian)
}

/// All bits of so many bytes or septets.
fn whole_bits(frames: &Frames<'_>, bytes: usize) -> u32 {
    frames.digit_bits * u32::try_from(bytes).unwrap_or(4)
}

/// Bits up to the highest that is ever set, or varies.
fn bits_in_use(frames: &Frames<'_>, codes: &[u64], whole: u32) -> u32 {
    // A check need not cover every byte.
    let allowed = codes.len() / if frames.verified { 300 } else { 50 };
    let used = |bit: u32| codes.iter().filter(|code| (*code >> bit) & 1 == 1).count() > allowed;
    let top = (0..whole).rev().find(|bit| used(*bit)).map_or(1, |bit| bit + 1);
    // A number whose top bits were never set may still own them, unless it is offset binary, in
    // which the top bit tells the sign and both were seen.
    let middle = 1u64 << (top - 1);
    let above = codes.iter().filter(|code| **code >= middle).count();
    let rare = codes.len() / 100;
    let both = above > rare && above < codes.len() - rare;
    if top < whole && both { top } else { whole }
}

/// Two's complement numbers huddle around zero, offset binary around the middle: the reading
/// under which the range is smaller is the right one.
fn coding_of(codes: &[u64], bits: u32) -> Coding {
    let half = f64::from(bits - 1).exp2();
    let plain: Vec<f64> = codes.iter().map(|code| as_float(*code)).collect();
    let signed = plain.iter().map(|v| if *v >= half { v - 2.0 * half } else { *v }).collect();
    let mean = plain.iter().sum::<f64>() / as_f64(plain.len().max(1));
    let (plain, signed) = (spread(plain, 0.005), spread(signed, 0.005));
    if plain < 0.999 * signed || (plain <= signed && (mean - half).abs() < half / 4.0) {
        Coding::OffsetBinary
    } else {
        Coding::Twos
    }
}

fn noise_of(frames: &Frames<'_>, field: &Field) -> f64 {
    let raw = |start: usize| raw_float(field.raw(frames.frame(start), frames.digit_bits));
    median(frames.neighbours().take(SAMPLES).map(|(a, b)| (raw(b) - raw(a)).abs()).collect())
}

/// A float has no full scale of its own: its motion is held against its noise.
fn float_motion(frames: &Frames<'_>, window: Window) -> (Motion, f64) {
    let value = |start: usize| {
        let code = frames.number(start, window.at, 4, window.big_endian);
        u32::try_from(code).map_or(0.0, |code| f64::from(f32::from_bits(code)))
    };
    let values: Vec<f64> = sampled(frames).map(value).collect();
    let range = spread(values.clone(), 0.03);
    let motion = Motion::of(&values, 2.0 * range);
    if motion.turned {
        return (motion, 0.0);
    }
    (Motion { excursion: 0.0, turned: false }, REST_EXCURSION)
}

/// A 16-bit word that carries other quantities now and then: bits 12 and 13 say which.
fn channel_word(frames: &Frames<'_>, rate: &mut Moved) -> Option<Moved> {
    let field = &mut rate.field;
    if field.bytes != 2 || frames.digit_bits != 8 || field.coding == Coding::Float {
        return None;
    }
    let (mut zero, mut other, mut beyond) = (0usize, 0usize, 0usize);
    for start in &frames.starts {
        match frames.number(*start, field.at, 2, field.big_endian) >> 12 {
            0 => zero += 1,
            1..=3 => other += 1,
            _ => beyond += 1,
        }
    }
    let all = frames.count();
    if 10 * zero < 9 * all || 500 * other < all || 10 * other > all || 200 * beyond > all {
        return None;
    }
    let codes: Vec<u64> = sampled(frames)
        .map(|start| frames.number(start, field.at, 2, field.big_endian))
        .filter(|code| code >> 12 == 0)
        .collect();
    (field.bits, field.only_channel_zero) = (12, true);
    field.coding = coding_of(&codes, 12);
    let in_zero: Vec<f64> = codes.iter().map(|code| signed(*code, field.coding)).collect();
    rate.motion = Motion::of(&in_zero, 4096.0);
    let channel = Field {
        role: Role::Channel,
        bits: 2,
        shift: 12,
        coding: Coding::Unsigned,
        only_channel_zero: false,
        ..*field
    };
    Some(Moved { field: channel, motion: Motion::default(), noise: 0.0 })
}

fn signed(code: u64, coding: Coding) -> f64 {
    match coding {
        Coding::Twos if code >= 2048 => as_float(code) - 4096.0,
        _ => as_float(code),
    }
}

#[expect(clippy::cast_precision_loss, reason = "raw values of at most 32 bits")]
fn raw_float(raw: i64) -> f64 {
    raw as f64
}
