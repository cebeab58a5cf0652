//! What others read: JUnit and the report.

use crate::desk::{Numbers, SUITE, Silent, suite};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use struna::validate::junit::write_junit;
use struna::validate::report::html;
use struna::validate::{
    Column, Judgement, Plan, Requirement, Results, Statistic, Suite, judge, run,
};
use struna_kernel::Seed;

/// A campaign with a requirement of each verdict.
fn judged() -> (Vec<Suite>, Plan, Results, Vec<Judgement>) {
    let rms = Statistic::Rms(Column::AngleHalf2Deg);
    let of = |range| Requirement::new(("small & sound", "second <&>"), rms, range);
    let requirements = vec![of(0.0..=100.0), of(50.0..=100.0), of(0.0..=0.7).as_control()];
    let case = Box::new(Numbers { name: "small & sound", fails: false });
    let suites = vec![suite(vec![case], requirements)];
    let plan = Plan { runs: None, seed: Seed(3), threads: 1 };
    let results = run(&suites, &plan, &Silent);
    assert_eq!(results.rows.len(), 6, "the suite's own three runs of two estimators");
    let judgements = judge(&suites, &results);
    (suites, plan, results, judgements)
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> String {
    let value = tag.try_get_attribute(name).unwrap().unwrap();
    value.normalized_value(quick_xml::XmlVersion::Explicit1_0).unwrap().into_owned()
}

#[test]
fn junit_is_well_formed_and_counts_what_it_holds() {
    let (suites, _, results, judgements) = judged();
    let mut xml = Vec::new();
    write_junit(&suites, &results, &judgements, &mut xml).unwrap();
    let text = String::from_utf8(xml).unwrap();
    let mut reader = Reader::from_str(&text);
    reader.config_mut().check_end_names = true;
    let (mut open, mut cases, mut failures, mut skipped) = (0, 0, 0, 0);
    loop {
        match reader.read_event().unwrap() {
            Event::Start(tag) => {
                open += 1;
                match tag.name().as_ref() {
                    "testsuite" | "testsuites" => {
                        let counts = ["tests", "failures", "skipped", "errors"];
                        assert_eq!(counts.map(|n| attribute(&tag, n)), ["3", "1", "1", "0"]);
                    }
                    "testcase" => {
                        cases += 1;
                        let class = attribute(&tag, "classname");
                        assert_eq!(class, format!("{SUITE}.second <&>"));
                        assert!(attribute(&tag, "name").starts_with("small & sound: RMS"));
                    }
                    _ => {}
                }
            }
            Event::Empty(tag) => match tag.name().as_ref() {
                "failure" => {
                    failures += 1;
                    assert!(attribute(&tag, "message").contains("NOT MET"));
                }
                "skipped" => skipped += 1,
                _ => {}
            },
            Event::End(_) => open -= 1,
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!((open, cases, failures, skipped), (0, 3, 1, 1), "{text}");
}

#[test]
fn the_report_stands_alone_and_says_what_it_found() {
    let suites = vec![Suite::named("kicks").unwrap(), Suite::named("paper").unwrap()];
    let plan = Plan { runs: Some(1), seed: Seed(3), threads: 2 };
    let results = run(&suites, &plan, &Silent);
    let judgements = judge(&suites, &results);
    let page = html(&suites, &plan, &results, &judgements).unwrap();
    for foreign in ["http://", "https://", "<script", "<link", "src=", "url("] {
        // The name space of SVG is a name, not a place to fetch from.
        let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        assert!(!page.contains(foreign), "{foreign}");
    }
    assert_eq!(page.matches("<svg").count(), 6, "four figures of kicks, two of the papers");
    assert!(page.contains("prefers-color-scheme:dark") && page.contains("currentColor"));
    assert_eq!(page.matches("<tr>").count(), judgements.len() + 2 + 3, "a line for each");
    assert!(!page.contains("NaN"));
}

#[test]
fn names_that_look_like_markup_are_text_in_the_report() {
    let (suites, plan, results, judgements) = judged();
    let page = html(&suites, &plan, &results, &judgements).unwrap();
    assert!(page.contains("second &lt;&amp;&gt;") && !page.contains("second <&>"), "{page}");
    let counts = "3 requirements: 1 met, 1 not met, 1 not decided by so many runs";
    assert!(page.contains(counts), "{page}");
}
