//! The FMI 3.0 model description.

use crate::Unit;
use crate::model::ModelType;
use crate::variable::{Kind, Variable};
use crate::xml::{
    Dialect, Document, domain_attributes, list, model_description, outputs, variable_attributes,
};

/// The text of `modelDescription.xml`.
pub(crate) fn xml(model_type: &ModelType) -> String {
    let dialect = Dialect {
        fmi_version: "3.0",
        token_attribute: "instantiationToken",
        state_attributes: ["canGetAndSetFMUState", "canSerializeFMUState"],
        write_types,
        write_variable,
        write_structure,
    };
    model_description(model_type, &dialect)
}

/// Units reach variables through declared types: the `fmi` crate rejects `unit` on a variable.
fn write_types(document: &mut Document, units: &[Unit]) {
    document.element("TypeDefinitions", vec![], |d| {
        for unit in units {
            let quantity = unit.quantity();
            let attributes = vec![
                ("name", quantity.into()),
                ("quantity", quantity.into()),
                ("unit", unit.name().into()),
            ];
            d.leaf("Float64Type", attributes);
        }
    });
}

fn write_variable(document: &mut Document, variable: &Variable) {
    let mut attributes = variable_attributes(variable);
    let name = match variable.domain.kind() {
        Kind::Float64 => {
            attributes.push(("declaredType", variable.unit().quantity().into()));
            "Float64"
        }
        Kind::Int32 => "Int32",
        Kind::Boolean => "Boolean",
    };
    attributes.extend(domain_attributes(variable));
    document.leaf(name, attributes);
}

/// Variables are named by value reference. Outputs change only in steps, so none depends on the
/// present inputs.
fn write_structure(document: &mut Document, variables: &[Variable]) {
    let unknown = |d: &mut Document, name, v: &Variable, dependencies: String| {
        let reference = v.value_reference.to_string();
        d.leaf(name, vec![("valueReference", reference), ("dependencies", dependencies)]);
    };
    for v in outputs(variables) {
        unknown(document, "Output", v, String::new());
    }
    for v in outputs(variables) {
        unknown(document, "InitialUnknown", v, list(v.start_depends_on.iter().copied()));
    }
}
