//! JUnit XML as CI systems read it: the elements and attributes that `junit-10.xsd` of Jenkins' xUnit
//! plugin allows, written down anew.

use roxmltree::{Document, Node};
use saarcor_kit::dut::InProcess;
use saarcor_kit::hash::SetHash;
use saarcor_kit::kind::{Kind as _, Oracle};
use saarcor_kit::run::{Options, default_suite, run};

/// Name, required attributes, further attributes, and children of an element.
type Rule = (&'static str, &'static [&'static str], &'static [&'static str], &'static [&'static str]);

const RULES: &[Rule] = &[
    ("testsuites", &[], &["name", "time", "tests", "failures", "errors"], &["testsuite"]),
    (
        "testsuite",
        &["name", "tests", "failures", "errors"],
        &["group", "time", "skipped", "timestamp", "hostname", "id", "package", "file", "log", "url"],
        &["testsuite", "properties", "testcase", "system-out", "system-err"],
    ),
    (
        "testcase",
        &["name"],
        &["time", "classname", "group"],
        &["skipped", "error", "failure", "system-out", "system-err"],
    ),
    ("failure", &[], &["type", "message"], &[]),
];

fn check(node: Node<'_, '_>) {
    let name = node.tag_name().name();
    let (_, required, further, children) =
        RULES.iter().find(|(known, ..)| *known == name).unwrap_or_else(|| panic!("an element {name}"));
    for attribute in node.attributes() {
        assert!(required.contains(&attribute.name()) || further.contains(&attribute.name()), "{attribute:?}");
    }
    assert!(required.iter().all(|attribute| node.has_attribute(*attribute)), "{name} lacks an attribute");
    for child in node.children().filter(Node::is_element) {
        assert!(children.contains(&child.tag_name().name()), "{child:?} in {name}");
        check(child);
    }
}

#[test]
fn junit_is_as_ci_systems_read_it() {
    // All sets are wrong, in an answer that XML has to escape.
    struct Zero;
    impl saarcor_kit::serve::Served for Zero {
        fn observes(&self) -> String {
            "set".to_owned()
        }
        fn answer(&mut self, _: &[u8], answer: &mut Vec<u8>) -> Result<(), &'static str> {
            answer.extend_from_slice(b"]]><&\"\x01");
            Ok(())
        }
    }
    let broken = InProcess::new(Box::new(|_, _| Ok(Box::new(Zero))));
    for dut in [InProcess::oracle(Oracle::Naive), broken] {
        let options = Options { requests: 100, ..Options::default() };
        let planned = default_suite(&SetHash, &options).expect("suites");
        let report = run("a \"dut\" <x>", &dut, &SetHash, &planned, &options, &|_| ()).expect("it runs");
        let text = report.junit().expect("XML");
        let document = Document::parse(&text).expect("well-formed");
        check(document.root_element());
        let count = |node: Node<'_, '_>, name| -> usize {
            node.attribute(name).expect(name).parse().expect("a number")
        };
        let cases = |name| document.descendants().filter(|node| node.has_tag_name(name)).count();
        let root = document.root_element();
        assert_eq!((count(root, "tests"), count(root, "failures")), (cases("testcase"), cases("failure")));
        assert_eq!(cases("testsuite"), report.requirements.len());
        assert_eq!(cases("failure") > 0, !report.failures.is_empty(), "{}", SetHash.name());
    }
}
