//! Verdicts as JUnit XML, for machines that gather test results.

use super::campaign::Results;
use super::requirement::{Judgement, Verdict};
use super::suite::Suite;
use super::table::cells;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesStart, BytesText, Event};
use std::io::{self, Write};

/// Writes `judgements`, a test suite for each suite and a test case for each requirement: not met
/// is a failure, not decided is skipped. No times and no dates, so that equal campaigns write equal
/// files.
///
/// # Errors
/// Those of `out`.
pub fn write_junit(
    suites: &[Suite],
    results: &Results,
    judgements: &[Judgement],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut xml = Writer::new_with_indent(out, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let head = with_counts(BytesStart::new("testsuites"), judgements.iter());
    xml.write_event(Event::Start(head.borrow()))?;
    for suite in suites {
        let of: Vec<&Judgement> = judgements.iter().filter(|j| j.suite == suite.name).collect();
        let mut head = BytesStart::new("testsuite");
        head.push_attribute(("name", format!("struna.validate.{}", suite.name).as_str()));
        let head = with_counts(head, of.iter().copied());
        xml.write_event(Event::Start(head.borrow()))?;
        properties(&mut xml, results)?;
        for judgement in of {
            case(&mut xml, judgement)?;
        }
        xml.write_event(Event::End(head.to_end()))?;
    }
    xml.write_event(Event::End(head.to_end()))?;
    xml.get_mut().write_all(b"\n")
}

fn with_counts<'a, 'j>(
    mut head: BytesStart<'a>,
    judgements: impl Iterator<Item = &'j Judgement> + Clone,
) -> BytesStart<'a> {
    let count = |verdict| judgements.clone().filter(|j| j.verdict == verdict).count().to_string();
    let all = judgements.clone().count().to_string();
    head.push_attribute(("tests", all.as_str()));
    head.push_attribute(("failures", count(Verdict::NotMet).as_str()));
    head.push_attribute(("errors", "0"));
    head.push_attribute(("skipped", count(Verdict::Undecided).as_str()));
    head
}

type Out<'a> = Writer<&'a mut dyn Write>;

fn properties(xml: &mut Out<'_>, results: &Results) -> io::Result<()> {
    let (done, planned) = results.done;
    let all = [
        ("runs_done", done.to_string()),
        ("runs_planned", planned.to_string()),
        ("partial", results.is_partial().to_string()),
    ];
    xml.create_element("properties").write_inner_content(|xml| {
        for (name, value) in &all {
            xml.create_element("property")
                .with_attributes([("name", *name), ("value", value.as_str())])
                .write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

fn case(xml: &mut Out<'_>, judgement: &Judgement) -> io::Result<()> {
    let [case, estimator, what, measured, required, verdict] = cells(judgement);
    let (name, class) = (format!("{case}: {what}"), format!("{}.{estimator}", judgement.suite));
    let message = format!("{verdict}: measured {measured}, required {required}");
    let element = xml
        .create_element("testcase")
        .with_attributes([("name", name.as_str()), ("classname", class.as_str())]);
    let word = match judgement.verdict {
        Verdict::Met => "system-out",
        Verdict::NotMet => "failure",
        Verdict::Undecided => "skipped",
    };
    element.write_inner_content(|xml| {
        let inner = xml.create_element(word);
        if judgement.verdict == Verdict::Met {
            inner.write_text_content(BytesText::new(&message))?;
        } else {
            inner.with_attribute(("message", message.as_str())).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}
