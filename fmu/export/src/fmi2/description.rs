//! The FMI 2.0 model description.

use crate::model::ModelType;
use crate::variable::{Kind, Variable};
use crate::xml::{
    Dialect, Document, domain_attributes, list, model_description, outputs, variable_attributes,
};

/// The text of `modelDescription.xml`.
pub(crate) fn xml(model_type: &ModelType) -> String {
    let dialect = Dialect {
        fmi_version: "2.0",
        token_attribute: "guid",
        state_attributes: ["canGetAndSetFMUstate", "canSerializeFMUstate"],
        write_types: |_, _| (), // the unit stands on the variable
        write_variable,
        write_structure,
    };
    model_description(model_type, &dialect)
}

fn write_variable(document: &mut Document, variable: &Variable) {
    let mut attributes = domain_attributes(variable);
    let name = match variable.domain.kind() {
        Kind::Float64 => {
            attributes.insert(0, ("unit", variable.unit().name().into()));
            attributes.insert(0, ("quantity", variable.unit().quantity().into()));
            "Real"
        }
        Kind::Int32 => "Integer",
        Kind::Boolean => "Boolean",
    };
    document.element("ScalarVariable", variable_attributes(variable), |d| d.leaf(name, attributes));
}

/// Variables are named by their place in the document, counted from 1. Outputs change only in
/// steps, so none depends on the present inputs.
fn write_structure(document: &mut Document, variables: &[Variable]) {
    let place = |reference: u32| reference + 1;
    let unknown = |d: &mut Document, v: &Variable, dependencies: String| {
        let index = place(v.value_reference).to_string();
        d.leaf("Unknown", vec![("index", index), ("dependencies", dependencies)]);
    };
    document.element("Outputs", vec![], |d| {
        outputs(variables).for_each(|v| unknown(d, v, String::new()));
    });
    document.element("InitialUnknowns", vec![], |d| {
        outputs(variables).for_each(|v| {
            unknown(d, v, list(v.start_depends_on.iter().map(|&r| place(r))));
        });
    });
}
