//! JUnit XML as CI systems read it: the elements and attributes that both `junit-10.xsd` of Jenkins' xUnit
//! plugin and `JUnit.xsd` of Windy Road (Ant's tasks) allow and ask for, written down anew.

use roxmltree::{Document, Node};
use saarcor_kit::dut::Dut;
use saarcor_kit::dut::InProcess;
use saarcor_kit::error::Error;
use saarcor_kit::hash::SetHash;
use saarcor_kit::kind::{Kind as _, Oracle};
use saarcor_kit::plan::{Options, default_suite};
use saarcor_kit::run::run;
use std::time::UNIX_EPOCH;

/// Name, attributes, and children of an element, all of which both schemas allow; and ask for, where they
/// are there once.
type Rule = (&'static str, &'static [&'static str], &'static [&'static str]);

const RULES: &[Rule] = &[
    ("testsuites", &[], &["testsuite"]),
    (
        "testsuite",
        &["name", "tests", "failures", "errors", "time", "timestamp", "hostname", "id", "package"],
        &["properties", "testcase", "system-out", "system-err"],
    ),
    ("properties", &[], &["property"]),
    ("property", &["name", "value"], &[]),
    ("testcase", &["name", "time", "classname"], &["skipped", "error", "failure"]),
    ("skipped", &[], &[]),
    ("failure", &["type", "message"], &[]),
    ("error", &["type", "message"], &[]),
    ("system-out", &[], &[]),
    ("system-err", &[], &[]),
];

fn check(node: Node<'_, '_>) {
    let name = node.tag_name().name();
    let (_, attributes, children) =
        RULES.iter().find(|(known, ..)| *known == name).unwrap_or_else(|| panic!("an element {name}"));
    let mut has: Vec<_> = node.attributes().map(|attribute| attribute.name()).collect();
    let mut asked = attributes.to_vec();
    // Both allow it in a suite.
    has.retain(|name| *name != "skipped");
    has.sort_unstable();
    asked.sort_unstable();
    assert_eq!(has, asked, "{name}");
    let order = |child: Node<'_, '_>| children.iter().position(|known| child.has_tag_name(*known));
    let places: Vec<_> = node.children().filter(Node::is_element).map(order).collect();
    assert!(places.is_sorted() && !places.contains(&None), "{node:?}");
    let all_there = |name: &&str| node.children().any(|child| child.has_tag_name(*name));
    assert!(name != "testsuite" || children.iter().all(all_there));
    node.children().filter(Node::is_element).for_each(check);
}

#[test]
fn junit_is_as_ci_systems_read_it() {
    // All sets are wrong, in an answer that XML has to escape.
    struct Zero;
    impl saarcor_kit::implementation::Implementation for Zero {
        fn observes(&self) -> String {
            "set".to_owned()
        }
        fn answer(&mut self, _: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
            answer.extend_from_slice(b"]]><&\"\x01\xef\xbf\xbe\xef\xbf\xbf\xed\xa0\x80\x1b[0m\0");
            Ok(())
        }
    }
    let broken = InProcess::new(Box::new(|_, _| Ok(Box::new(Zero))));
    let none = InProcess::new(Box::new(|_, _| Err(Error::Unsupported("hash".to_owned()))));
    let duts: [(&dyn Dut, bool); 3] =
        [(&InProcess::oracle(Oracle::Naive), false), (&broken, false), (&none, true)];
    for (dut, is_incomplete) in duts {
        let options = Options { quick: true, requests: 100, ..Options::default() };
        let planned = default_suite(&SetHash, &options).expect("suites");
        let report =
            run("a \"dut\" <x> \u{ffff}\u{1b}", dut, &SetHash, &planned, &options, &|_| ()).expect("it runs");
        let text = report.junit(UNIX_EPOCH).expect("XML");
        let document = Document::parse(&text).expect("well-formed");
        check(document.root_element());
        let all = |name| document.descendants().filter(move |node| node.has_tag_name(name));
        for suite in all("testsuite") {
            assert_eq!(suite.attribute("timestamp"), Some("1970-01-01T00:00:00"));
            let inside = |name| suite.descendants().filter(|node| node.has_tag_name(name)).count();
            assert_eq!(suite.attribute("skipped").unwrap_or("0"), inside("skipped").to_string());
            for (attribute, name) in [("tests", "testcase"), ("failures", "failure"), ("errors", "error")] {
                assert_eq!(suite.attribute(attribute), Some(inside(name).to_string().as_str()));
            }
        }
        // A case for each session that was planned, under its own name, whatever became of it.
        let mut names: Vec<_> =
            all("testcase").map(|case| (case.attribute("classname"), case.attribute("name"))).collect();
        assert_eq!(names.len(), planned.len() + usize::from(is_incomplete));
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), planned.len() + usize::from(is_incomplete));
        assert_eq!(all("error").count(), usize::from(is_incomplete));
        assert_eq!(all("failure").count() > 0, !report.failures.is_empty(), "{}", SetHash.name());
    }
}
