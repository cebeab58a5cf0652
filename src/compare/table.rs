//! A comparison as text.

use super::{ComparedFile, Comparison, Difference};
use std::fmt::{self, Display, Formatter};

const LETTERS: [char; 2] = ['A', 'B'];

/// The table that commands print.
impl Display for Comparison {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (letter, file) in LETTERS.into_iter().zip(&self.files) {
            write_file(f, letter, file)?;
        }
        let [from_s, to_s] = self.span_s;
        writeln!(f, "\n{} common instants, {from_s} s to {to_s} s", self.instants)?;
        for (letter, file) in LETTERS.into_iter().zip(&self.files) {
            write_alone(f, letter, file)?;
        }
        self.write_table(f)
    }
}

fn write_file(f: &mut Formatter<'_>, letter: char, file: &ComparedFile) -> fmt::Result {
    writeln!(f, "{letter}  {}", file.path.display())?;
    file.comments.iter().try_for_each(|comment| writeln!(f, "   {}", comment.escape_debug()))
}

/// What of a file was not compared.
fn write_alone(f: &mut Formatter<'_>, letter: char, file: &ComparedFile) -> fmt::Result {
    for (rows, place) in [(file.rows_between, "between them"), (file.rows_after, "after them")] {
        if rows > 0 {
            writeln!(f, "{rows} more in {letter} {place}")?;
        }
    }
    if !file.columns_alone.is_empty() {
        writeln!(f, "only in {letter}: {}", file.columns_alone.join(", "))?;
    }
    Ok(())
}

impl Comparison {
    fn write_table(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let names = self.differences.iter().map(|difference| difference.name.chars().count());
        let width = names.max().unwrap_or(0).max("column".len());
        write!(f, "\n{:width$}  {:>10}   {:>10}  {:<5}", "column", "largest", "RMS", "")?;
        write!(f, "  {:>14}  {:>10}  {:>10}", "at, s", "largest", "RMS")?;
        for difference in &self.differences {
            let mark = if self.is_largest_of_its_unit(difference) { '*' } else { ' ' };
            write!(f, "\n{:width$}  ", difference.name)?;
            write_difference(f, difference, mark)?;
        }
        let differs = |difference: &Difference| difference.largest.is_some_and(|size| size > 0.0);
        let all_equal = !self.differences.iter().any(differs);
        write!(f, "\n{}", if all_equal { "nothing differs" } else { "* largest of its unit" })
    }

    fn is_largest_of_its_unit(&self, one: &Difference) -> bool {
        let of_its_unit = self.differences.iter().filter(|other| other.unit == one.unit);
        let largest = of_its_unit.filter_map(|other| other.largest).fold(0.0, f64::max);
        one.largest.is_some_and(|size| size > 0.0 && size >= largest)
    }
}

fn write_difference(f: &mut Formatter<'_>, difference: &Difference, mark: char) -> fmt::Result {
    let Difference { unit, at_s, rms, .. } = difference;
    let Some(largest) = difference.largest else {
        return write!(f, "{:>10}", "no value");
    };
    if largest == 0.0 {
        return write!(f, "{:>10}   {:>10}  {unit}", 0, 0);
    }
    write!(f, "{largest:>10.3e} {mark} {rms:>10.3e}  {unit:<5}  {at_s:>14}")?;
    if let Some((unit, rad)) = difference.in_degrees() {
        write!(f, "  {:>10.3e}  {:>10.3e}  {unit}", largest / rad, rms / rad)?;
    }
    Ok(())
}
