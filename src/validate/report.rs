//! The report: one HTML file with its figures inside, readable without a network.

use super::campaign::{Plan, Results};
use super::requirement::{Judgement, Verdict};
use super::suite::Suite;
use super::table::{cells, counts, outcome, sentence};
use super::{Row, row::Column};
use crate::figure::FigureError;
use std::fmt::Write;

/// Colours by the reader's own choice of light or dark; figures take theirs from the text.
const STYLE: &str = "\
:root{color-scheme:light dark;--page:#fff;--text:#1c1f23;--dim:#5c646d;--line:#d8dde2;\
--met:#007a55;--fail:#c0392b;--open:#8a6d00}\
@media(prefers-color-scheme:dark){:root{--page:#15181c;--text:#e3e7eb;--dim:#9aa4ae;\
--line:#343b43;--met:#3cc796;--fail:#ff7b6b;--open:#e0b93a}}\
body{margin:0 auto;max-width:1040px;padding:24px;background:var(--page);color:var(--text);\
font:16px/1.5 system-ui,sans-serif}\
h1{font-size:1.7em;margin:.2em 0}h2{margin-top:2.2em;border-top:1px solid var(--line);\
padding-top:.8em}p,figcaption{max-width:46em}figcaption,.dim{color:var(--dim);font-size:.92em}\
figure{margin:1.6em 0;overflow-x:auto}svg{max-width:100%;height:auto}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9em;width:100%}\
th,td{text-align:left;padding:.28em .7em .28em 0;border-bottom:1px solid var(--line);\
vertical-align:top}td{font-variant-numeric:tabular-nums}\
.met{color:var(--met)}.fail{color:var(--fail);font-weight:600}.open{color:var(--open)}\
.note{border-left:4px solid var(--fail);padding:.3em 1em}";

/// Writes the report of a campaign.
///
/// # Errors
/// [`FigureError`] when the plotting library fails.
pub fn html(
    suites: &[Suite],
    plan: &Plan,
    results: &Results,
    judgements: &[Judgement],
) -> Result<String, FigureError> {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\">\
         <title>How far the estimators can be trusted</title><style>{STYLE}</style></head><body>\n\
         <h1>How far the estimators can be trusted</h1>\n"
    );
    head(&mut page, plan, results, judgements);
    contents(&mut page, suites, judgements);
    for suite in suites {
        section(&mut page, suite, results, judgements)?;
    }
    stopped(&mut page, results);
    page.push_str("</body></html>\n");
    Ok(page)
}

fn head(page: &mut String, plan: &Plan, results: &Results, judgements: &[Judgement]) {
    let (done, planned) = results.done;
    let _ = writeln!(
        page,
        "<p class=\"dim\">struna {}, seed {}, {} rows from {done} runs.</p><p>{}.</p>",
        env!("CARGO_PKG_VERSION"),
        plan.seed.0,
        results.rows.len(),
        sentence(judgements),
    );
    if results.is_partial() {
        let _ = writeln!(
            page,
            "<p class=\"note\"><b>Partial result.</b> The campaign was stopped after {done} of \
             {planned} runs. What follows holds for these.</p>"
        );
    }
    page.push_str(
        "<p>A requirement is <span class=\"met\">met</span> when the whole 95 % interval of what \
         was measured lies within what is required, <span class=\"fail\">not met</span> when the \
         whole interval lies outside, and <span class=\"open\">not decided</span> when so many \
         runs leave it open. A control is met when an estimator that is not up to a case is seen \
         to fail: without that the measure would measure nothing.</p>\n",
    );
}

/// One line for each suite.
fn contents(page: &mut String, suites: &[Suite], judgements: &[Judgement]) {
    page.push_str(
        "<table><tr><th>suite</th><th>met</th><th>not met</th><th>not decided</th></tr>\n",
    );
    for suite in suites {
        let of: Vec<Judgement> =
            judgements.iter().filter(|j| j.suite == suite.name).cloned().collect();
        let [met, not_met, open] = counts(&of);
        let fail = if not_met > 0 { "fail" } else { "dim" };
        let name = suite.name;
        let _ = writeln!(
            page,
            "<tr><td><a href=\"#{name}\">{name}</a></td><td class=\"met\">{met}</td>\
             <td class=\"{fail}\">{not_met}</td><td class=\"open\">{open}</td></tr>"
        );
    }
    page.push_str("</table>\n");
}

fn section(
    page: &mut String,
    suite: &Suite,
    results: &Results,
    judgements: &[Judgement],
) -> Result<(), FigureError> {
    let rows = results.of(suite.name);
    let (name, about) = (suite.name, escaped(suite.about));
    let _ = writeln!(page, "<h2 id=\"{name}\">{name}</h2><p>{about}</p>");
    let runs = rows.iter().map(|row| row.run + 1).max().unwrap_or(0);
    let _ = writeln!(page, "<p class=\"dim\">{} rows, up to {runs} runs a cell.</p>", rows.len());
    if !rows.is_empty() {
        for figure in (suite.draw)(&rows)? {
            let caption = escaped(&figure.caption);
            let _ =
                writeln!(page, "<figure>{}<figcaption>{caption}</figcaption></figure>", figure.svg);
        }
    }
    page.push_str(
        "<div class=\"wide\"><table><tr><th>case</th><th>estimator</th><th>what</th>\
         <th>measured [95 %]</th><th>required</th><th>verdict</th></tr>\n",
    );
    for judgement in judgements.iter().filter(|judgement| judgement.suite == suite.name) {
        verdict_line(page, judgement);
    }
    page.push_str("</table></div>\n");
    Ok(())
}

fn verdict_line(page: &mut String, judgement: &Judgement) {
    let class = match judgement.verdict {
        Verdict::Met => "met",
        Verdict::NotMet => "fail",
        Verdict::Undecided => "open",
    };
    page.push_str("<tr>");
    let [texts @ .., verdict] = cells(judgement);
    for text in texts {
        let _ = write!(page, "<td>{}</td>", escaped(&text));
    }
    let _ = writeln!(page, "<td class=\"{class}\">{verdict}</td></tr>");
}

/// The first few runs that stopped, with their reasons.
fn stopped(page: &mut String, results: &Results) {
    let stopped: Vec<&Row> = results.rows.iter().filter(|row| !row.is_complete()).collect();
    if stopped.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<h2>Runs that stopped</h2><p>{} of {} rows; each counts as infinitely wrong.</p>\
         <div class=\"wide\"><table><tr><th>suite</th><th>case</th><th>estimator</th>\
         <th>run</th><th>period, s</th><th>why</th></tr>",
        stopped.len(),
        results.rows.len(),
    );
    for row in stopped.into_iter().take(50) {
        let period = row.get(Column::PeriodS).map_or_else(String::new, |s| format!("{s:.2}"));
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{period}</td><td>{}</td></tr>",
            row.suite,
            escaped(&row.case),
            escaped(&row.estimator),
            row.run,
            escaped(outcome(row)),
        );
    }
    page.push_str("</table></div>\n");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
