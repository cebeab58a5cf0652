//! What the two model descriptions share, and a small writer for both.

use crate::Unit;
use crate::log::LogCategory;
use crate::model::ModelType;
use crate::variable::{Domain, Role, Variable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};

/// Name and value of an attribute.
pub(crate) type Attribute = (&'static str, String);

/// What made the model description.
const GENERATION_TOOL: &str = concat!("struna-fmi-export ", env!("CARGO_PKG_VERSION"));

/// An XML document in memory.
pub(crate) struct Document(Writer<Vec<u8>>);

impl Document {
    /// A document whose root element has been opened.
    fn opened(root: &'static str, attributes: Vec<Attribute>) -> Self {
        let mut document = Self(Writer::new_with_indent(Vec::new(), b' ', 2));
        document.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        document.event(Event::Start(tag(root, attributes)));
        document
    }

    /// An element without content.
    pub(crate) fn leaf(&mut self, name: &'static str, attributes: Vec<Attribute>) {
        self.event(Event::Empty(tag(name, attributes)));
    }

    /// An element with the content that `write` writes.
    pub(crate) fn element(
        &mut self,
        name: &'static str,
        attributes: Vec<Attribute>,
        write: impl FnOnce(&mut Self),
    ) {
        self.event(Event::Start(tag(name, attributes)));
        write(self);
        self.event(Event::End(BytesEnd::new(name)));
    }

    fn event(&mut self, event: Event<'_>) {
        self.0.write_event(event).expect("writing into a Vec does not fail");
    }

    fn closed(mut self, root: &'static str) -> String {
        self.event(Event::End(BytesEnd::new(root)));
        let mut text = String::from_utf8(self.0.into_inner()).expect("only UTF-8 was written");
        text.push('\n');
        text
    }
}

fn tag(name: &'static str, attributes: Vec<Attribute>) -> BytesStart<'static> {
    let mut tag = BytesStart::new(name);
    for (key, value) in &attributes {
        tag.push_attribute((*key, value.as_str()));
    }
    tag
}

/// How the two versions of the standard differ in their model descriptions.
pub(crate) struct Dialect {
    pub(crate) fmi_version: &'static str,
    pub(crate) token_attribute: &'static str,
    pub(crate) state_attributes: [&'static str; 2],
    pub(crate) write_types: fn(&mut Document, &[Unit]),
    pub(crate) write_variable: fn(&mut Document, &Variable),
    pub(crate) write_structure: fn(&mut Document, &[Variable]),
}

const ROOT: &str = "fmiModelDescription";

/// The model description of `model_type` in one of the two dialects.
pub(crate) fn model_description(model_type: &ModelType, dialect: &Dialect) -> String {
    let description = &model_type.description;
    let mut document = Document::opened(
        ROOT,
        vec![
            ("fmiVersion", dialect.fmi_version.into()),
            ("modelName", description.name.into()),
            (dialect.token_attribute, model_type.instantiation_token().into()),
            ("description", description.description.into()),
            ("version", description.version.into()),
            ("generationTool", GENERATION_TOOL.into()),
            ("variableNamingConvention", "flat".into()),
        ],
    );
    let [get_and_set_state, serialize_state] = dialect.state_attributes;
    let capabilities = vec![
        ("modelIdentifier", description.name.into()),
        ("canHandleVariableCommunicationStepSize", "true".into()),
        (get_and_set_state, "true".into()),
        (serialize_state, "true".into()),
    ];
    document.leaf("CoSimulation", capabilities);
    let units = units(description.variables);
    document.element("UnitDefinitions", vec![], |d| units.iter().for_each(|u| write_unit(d, u)));
    (dialect.write_types)(&mut document, &units);
    document.element("LogCategories", vec![], write_log_categories);
    let experiment = &description.experiment;
    let experiment = vec![
        ("startTime", number(0.0)),
        ("stopTime", number(experiment.stop_time_s)),
        ("stepSize", number(experiment.step_size_s)),
    ];
    document.leaf("DefaultExperiment", experiment);
    document.element("ModelVariables", vec![], |d| {
        description.variables.iter().for_each(|v| (dialect.write_variable)(d, v));
    });
    document.element("ModelStructure", vec![], |d| {
        (dialect.write_structure)(d, description.variables);
    });
    document.closed(ROOT)
}

/// The units of a table, each once, in order of first use.
fn units(variables: &[Variable]) -> Vec<Unit> {
    let mut units = Vec::new();
    for variable in variables {
        let is_float = matches!(variable.domain, Domain::Float64 { .. });
        if is_float && !units.contains(&variable.unit()) {
            units.push(variable.unit());
        }
    }
    units
}

fn write_unit(document: &mut Document, unit: &Unit) {
    let base = unit.base().iter().map(|(name, exponent)| (*name, exponent.to_string())).collect();
    document.element("Unit", vec![("name", unit.name().into())], |d| d.leaf("BaseUnit", base));
}

fn write_log_categories(document: &mut Document) {
    for category in LogCategory::ALL {
        let name = category.name().to_str().expect("category names are ASCII").into();
        let attributes = vec![("name", name), ("description", category.description().into())];
        document.leaf("Category", attributes);
    }
}

/// Attributes that a variable has in both versions, without its type's own.
pub(crate) fn variable_attributes(variable: &Variable) -> Vec<Attribute> {
    let mut attributes = vec![
        ("name", variable.name.into()),
        ("valueReference", variable.value_reference.to_string()),
        ("description", variable.description.into()),
        ("causality", variable.causality().into()),
        ("variability", variable.variability().into()),
    ];
    attributes.extend(variable.initial().map(|initial| ("initial", initial.into())));
    attributes
}

/// Bounds that are narrower than the type, and the start value where one is due.
pub(crate) fn domain_attributes(variable: &Variable) -> Vec<Attribute> {
    let mut attributes = Vec::new();
    let mut push = |wanted: bool, key, value: String| {
        if wanted {
            attributes.push((key, value));
        }
    };
    match variable.domain {
        Domain::Float64 { start, min, max, .. } => {
            push(min > f64::MIN, "min", number(min));
            push(max < f64::MAX, "max", number(max));
            push(variable.has_start(), "start", number(start));
        }
        Domain::Int32 { start, min, max } => {
            push(min > i32::MIN, "min", min.to_string());
            push(max < i32::MAX, "max", max.to_string());
            push(variable.has_start(), "start", start.to_string());
        }
        Domain::Boolean { start } => push(variable.has_start(), "start", start.to_string()),
    }
    attributes
}

/// Shortest decimal text that reads back to the same bits.
fn number(value: f64) -> String {
    format!("{value:?}")
}

pub(crate) fn outputs(variables: &[Variable]) -> impl Iterator<Item = &Variable> {
    variables.iter().filter(|v| v.role == Role::Output)
}

/// Numbers separated by blanks, as XML Schema lists are written.
pub(crate) fn list(numbers: impl Iterator<Item = u32>) -> String {
    numbers.map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}
