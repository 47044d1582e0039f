//! The kit in process: all suites, without a child process.

use saarcor_kit::dut::InProcess;
use saarcor_kit::report::Verdict;
use saarcor_kit::run::{Options, default_suite, run};
use saarcor_kit::vm::{Vm, cache::CacheServed};

#[test]
fn conforms_at_every_level() {
    let dut = InProcess::new(Box::new(|_, config| Ok(Box::new(CacheServed::new(config, &my_cache::make)?))));
    let options = Options { requests: 100_000, ..Options::default() };
    let planned = default_suite(&Vm, &options).expect("the kit's suites");
    let report = run("my-cache", &dut, &Vm, &planned, &options, &|_| ()).expect("it runs");
    let failures: Vec<_> = report.failures.iter().map(|failure| failure.text()).collect();
    assert_eq!(report.verdict, Verdict::Conforms, "{}", failures.join("\n"));
}
