//! The kit in process: all suites, without a child process.

use saarcor_kit::dut::InProcess;
use saarcor_kit::plan::{Options, default_suite};
use saarcor_kit::report::ConformanceVerdict;
use saarcor_kit::run::run;
use saarcor_kit::vm::{Vm, cache::CacheAdapter};

#[test]
fn conforms_at_every_level() {
    let dut = InProcess::new(Box::new(|_, config| Ok(Box::new(CacheAdapter::new(config, &my_cache::make)?))));
    let options = Options { quick: true, requests: 100_000, ..Options::default() };
    let planned = default_suite(&Vm, &options).expect("the kit's suites");
    let report = run("my-cache", &dut, &Vm, &planned, &options, &|_| ()).expect("it runs");
    let failures: Vec<_> = report.failures.iter().map(|failure| failure.text()).collect();
    assert_eq!(report.verdict, ConformanceVerdict::Conforms, "{}", failures.join("\n"));
}
