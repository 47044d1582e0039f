//! The certificates of rounding errors: Gappa proves each with its least constant, not with the next one below, and the code's is no less.

use saarcor_proofs::certificates::{Certificate, certificates, gappa};
use std::fs;
use std::path::PathBuf;

fn path(certificate: &Certificate) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/certificates"))
        .join(format!("{}.g", certificate.name))
}

/// The constants of the code are held to the least ones, with Gappa or without.
#[test]
fn constants_of_the_code_are_no_less_than_what_is_proved() {
    for certificate in certificates() {
        let Certificate { name, least, slack, file, step, .. } = *certificate;
        let constant = (certificate.constant)();
        assert!(constant >= least, "{name}: {file} has {constant} steps of {step}, and {least} are proved");
        assert_eq!(
            constant > least,
            !slack.is_empty(),
            "{name}: {constant} steps, of which {least} are proved: {slack}"
        );
    }
    assert!(certificates().len() >= 12);
}

/// With `SAARCOR_WRITE_LISTS` set the scripts are written.
#[test]
fn scripts_are_those_of_the_code() {
    for certificate in certificates() {
        let (path, script) = (path(certificate), certificate.script(certificate.least));
        if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, script).expect("the script again");
        } else {
            let kept = fs::read_to_string(&path).unwrap_or_default();
            assert!(
                kept == script,
                "{} is old: SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-proofs --test certificates",
                path.display()
            );
        }
    }
    let kept = fs::read_dir(path(&certificates()[0]).parent().expect("a folder")).expect("a folder").count();
    assert_eq!(kept, certificates().len(), "a script without a certificate");
}

/// No constant is repeated here: scripts are made from those of the code.
#[test]
fn gappa_proves_the_constants_of_the_code() {
    for certificate in certificates() {
        let script = certificate.script((certificate.constant)());
        let Some((proved, said)) = gappa(&script) else {
            println!("not run: there is no gappa (Debian's package of that name)");
            return;
        };
        assert!(proved, "{} of {} is not proved: {said}\n{script}", certificate.name, certificate.file);
    }
}

#[test]
fn gappa_proves_the_least_constants_and_none_below() {
    if gappa("{ 0 <= 1 }\n").is_none() {
        println!("not run: there is no gappa (Debian's package of that name)");
        return;
    }
    for certificate in certificates() {
        let Certificate { name, least, .. } = *certificate;
        let (proved, said) = gappa(&certificate.script(least)).expect("Gappa");
        assert!(proved && !said.contains("hint"), "{name}: {least} steps are not proved: {said}");
        let below = certificate.below();
        let (proved, said) = gappa(&certificate.script(below)).expect("Gappa");
        assert!(
            !proved && said.contains("properties were not satisfied"),
            "{name}: {below} steps are proved, too: {said}"
        );
    }
}
