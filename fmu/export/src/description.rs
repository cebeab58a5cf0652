//! What a model says about itself, checked while it is compiled.

use crate::sha256::{Sha256, hex};
use crate::variable::{Domain, Role, Variable};

/// Name, version and interface of a model.
#[derive(Debug, Clone, Copy)]
pub struct ModelDescription {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) version: &'static str,
    pub(crate) variables: &'static [Variable],
    pub(crate) experiment: DefaultExperiment,
}

/// The experiment that an importer runs when it is told nothing else. It starts at 0 s.
#[derive(Debug, Clone, Copy)]
pub struct DefaultExperiment {
    /// End, s.
    pub stop_time_s: f64,
    /// Communication step size, s.
    pub step_size_s: f64,
}

impl ModelDescription {
    /// A description. `name` must be a C identifier: the shared library is named after it.
    ///
    /// # Panics
    /// While compiling, when the table does not begin with [`Variable::TIME`], a row's value
    /// reference is not its row number, two names are equal, a start value is out of bounds, or an
    /// output claims to start from something that is not set from outside.
    #[must_use]
    pub const fn new(
        name: &'static str,
        version: &'static str,
        description: &'static str,
        experiment: DefaultExperiment,
        variables: &'static [Variable],
    ) -> Self {
        assert!(is_identifier(name.as_bytes()), "the model name must be a C identifier");
        assert!(variables.len() > 1, "a model without variables cannot be observed");
        assert!(
            matches!(variables[0].role, Role::Independent) && same(variables[0].name, "time"),
            "the first variable must be Variable::TIME"
        );
        let mut row = 0;
        while row < variables.len() {
            check_row(variables, row);
            row += 1;
        }
        Self { name, description, version, variables, experiment }
    }

    /// The model's name, which is also its model identifier.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// What the model is, in a sentence.
    #[must_use]
    pub const fn description(&self) -> &'static str {
        self.description
    }

    /// The variable table.
    #[must_use]
    pub const fn variables(&self) -> &'static [Variable] {
        self.variables
    }

    /// 64 hexadecimal digits that change whenever the name, the version or anything in the
    /// variable table changes.
    pub(crate) const fn token(&self) -> [u8; 64] {
        let mut hash = with_text(with_text(Sha256::new(), self.name), self.version);
        let mut row = 0;
        while row < self.variables.len() {
            hash = with_variable(hash, &self.variables[row]);
            row += 1;
        }
        hex(&hash.finish())
    }
}

const fn check_row(variables: &[Variable], row: usize) {
    let variable = &variables[row];
    assert!(variable.value_reference as usize == row, "a value reference must be its row number");
    assert!(row == 0 || !matches!(variable.role, Role::Independent), "time is the first row only");
    let mut earlier = 0;
    while earlier < row {
        assert!(!same(variables[earlier].name, variable.name), "two variables have the same name");
        earlier += 1;
    }
    let within = match variable.domain {
        Domain::Float64 { start, min, max, .. } => min <= start && start <= max,
        Domain::Int32 { start, min, max } => min <= start && start <= max,
        Domain::Boolean { .. } => true,
    };
    // An output starts from a calculated value, not from its table row.
    assert!(within || matches!(variable.role, Role::Output), "a start value is out of bounds");
    let output = matches!(variable.role, Role::Output);
    assert!(output || !variable.on_demand, "only outputs are calculated on demand");
    let mut i = 0;
    while i < variable.start_depends_on.len() {
        let source = &variables[variable.start_depends_on[i] as usize];
        assert!(source.has_start(), "outputs start from parameters and inputs only");
        i += 1;
    }
}

const fn is_identifier(name: &[u8]) -> bool {
    let mut i = 0;
    while i < name.len() {
        let letter = name[i].is_ascii_alphabetic() || name[i] == b'_';
        if !(letter || (i > 0 && name[i].is_ascii_digit())) {
            return false;
        }
        i += 1;
    }
    !name.is_empty()
}

const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

/// Hashes a text with its length, so that no two tables run together.
const fn with_text(hash: Sha256, text: &str) -> Sha256 {
    with_number(hash, text.len() as u64).with(text.as_bytes())
}

const fn with_number(hash: Sha256, number: u64) -> Sha256 {
    hash.with(&number.to_le_bytes())
}

const fn with_variable(hash: Sha256, variable: &Variable) -> Sha256 {
    let hash = with_text(hash, variable.name);
    let hash = with_text(hash, variable.causality());
    let hash = with_text(hash, variable.variability());
    let hash = with_text(hash, variable.unit().name());
    let hash = with_text(hash, variable.description);
    let mut hash = with_number(hash, variable.domain.start_bits());
    let mut i = 0;
    while i < variable.start_depends_on.len() {
        hash = with_number(hash, variable.start_depends_on[i] as u64);
        i += 1;
    }
    match variable.domain {
        Domain::Float64 { min, max, .. } => {
            with_number(with_number(with_text(hash, "Float64"), min.to_bits()), max.to_bits())
        }
        Domain::Int32 { min, max, .. } => {
            let hash = with_number(with_text(hash, "Int32"), min.cast_unsigned() as u64);
            with_number(hash, max.cast_unsigned() as u64)
        }
        Domain::Boolean { .. } => with_text(hash, "Boolean"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unit;

    const EXPERIMENT: DefaultExperiment = DefaultExperiment { stop_time_s: 1.0, step_size_s: 0.1 };

    const fn table(start: f64, name: &'static str) -> [Variable; 2] {
        let domain = Domain::float64(Unit::S, start);
        [Variable::TIME, Variable::new(1, Role::Parameter, name, domain, "A period.")]
    }

    fn token(version: &'static str, variables: [Variable; 2]) -> [u8; 64] {
        let variables: &'static [Variable] = Box::leak(Box::new(variables));
        ModelDescription::new("Swing", version, "", EXPERIMENT, variables).token()
    }

    #[test]
    fn any_change_of_the_interface_changes_the_token() {
        let base = token("1", table(1.0, "period_s"));
        assert_eq!(base, token("1", table(1.0, "period_s")));
        assert_ne!(base, token("2", table(1.0, "period_s")));
        assert_ne!(base, token("1", table(2.0, "period_s")));
        assert_ne!(base, token("1", table(1.0, "span_s")));
        let mut tunable = table(1.0, "period_s");
        tunable[1].role = Role::TunableParameter;
        assert_ne!(base, token("1", tunable));
        let mut bounded = table(1.0, "period_s");
        bounded[1].domain = Domain::not_negative(Unit::S, 1.0);
        assert_ne!(base, token("1", bounded));
    }

    #[test]
    fn a_faulty_table_does_not_pass() {
        let refused = |edit: fn(&mut [Variable; 2])| {
            let mut variables = table(1.0, "period_s");
            edit(&mut variables);
            std::panic::catch_unwind(|| token("1", variables)).is_err()
        };
        assert!(!refused(|_| ()));
        assert!(refused(|t| t[1].value_reference = 7));
        assert!(refused(|t| t[1].name = "time"));
        assert!(refused(|t| t[1].domain = Domain::not_negative(Unit::S, -1.0)));
        assert!(refused(|t| t[1].start_depends_on = &[0]));
        assert!(refused(|t| t[1].on_demand = true));
        assert!(refused(|t| t.swap(0, 1)));
    }
}
