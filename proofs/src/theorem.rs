//! A theorem: what it says, what it needs, and its body; and the macro that declares the theorems
//! of a unit.

#[cfg(not(kani))]
use crate::engines::{Exhaustive, Judgement, Random};
#[cfg(any(not(kani), all(kani_stub, test)))]
use crate::source::Holds;

/// A registered theorem.
#[cfg(any(not(kani), all(kani_stub, test)))]
pub struct Theorem {
    /// The function's name.
    pub name: &'static str,
    /// The module in which it stands, with the crate's name before it.
    pub module: &'static str,
    /// The file in which it stands, from the root of the workspace on.
    pub file: &'static str,
    /// The requirement of SPEC.md.
    pub requirement: &'static str,
    /// What holds, in one English sentence.
    pub says: &'static str,
    /// Cases that an engine has to reach.
    pub covers: &'static [&'static str],
    /// Why Kani cannot judge it, where it cannot.
    pub not_for_kani: Option<&'static str>,
    /// The body for the exhaustive engine.
    #[cfg(not(kani))]
    pub exhaustive: fn(&mut Exhaustive) -> Holds,
    /// The body for the random engine.
    #[cfg(not(kani))]
    pub random: fn(&mut Random) -> Holds,
    /// The body as Kani has it, for whoever asks what it draws.
    #[cfg(kani)]
    pub recorded: fn(&mut crate::stub::Recorder) -> Holds,
}

#[cfg(any(not(kani), all(kani_stub, test)))]
impl Theorem {
    /// The unit of the model, by the place of its file: `vm::set`.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        self.module.split_once("::").map_or(self.module, |(_, unit)| unit)
    }

    /// The name by which Kani knows its harness.
    #[must_use]
    pub fn harness(&self) -> String {
        format!("{}::kani_proofs::{}", self.unit(), self.name)
    }

    /// Tries every case of its small scope, up to the first that fails.
    #[cfg(not(kani))]
    #[must_use]
    pub fn judge_exhaustively(&self) -> Judgement {
        Exhaustive::judge(self.covers, self.exhaustive)
    }

    /// Tries that many cases at random over its full scope, the same in every run, and shrinks the
    /// first that fails.
    #[cfg(not(kani))]
    #[must_use]
    pub fn judge_at_random(&self, cases: u32) -> Judgement {
        Random::judge(self.covers, self.random, cases)
    }
}

/// Declares the theorems of a unit. Of each it takes: a documentation comment, which is what the
/// theorem says; its requirement; what Kani needs, or why Kani cannot judge it; its covers; its
/// body.
///
/// `unwind 8` is Kani's bound for loops: more than the turns of the longest loop, and more than the
/// covers, over which there is a loop too. Kani fails where it is too low. `not_for_kani "reason"`
/// takes its place where Kani cannot judge the body: no harness is made, and the lists say why.
#[macro_export]
macro_rules! theorems {
    ($(
        $(#[doc = $says:literal])+
        #[$requirement:literal, $kani:ident $how:literal, covers [$($cover:literal),+]]
        fn $name:ident($source:ident) $body:block
    )+) => {
        $(
            $(#[doc = $says])+
            ///
            /// # Errors
            /// Where it does not hold for the values drawn, or does not speak of them.
            pub fn $name<S: $crate::source::Source>($source: &mut S) -> $crate::source::Holds {
                $body
                Ok(())
            }
        )+

        /// The theorems of this unit.
        #[cfg(any(not(kani), all(kani_stub, test)))]
        pub const THEOREMS: &[$crate::theorem::Theorem] = &[$($crate::theorem::Theorem {
            name: stringify!($name),
            module: module_path!(),
            file: file!(),
            requirement: $requirement,
            says: concat!($($says),+).trim_ascii_start(),
            covers: &[$($cover),+],
            not_for_kani: $crate::reason_without_kani!($kani $how),
            #[cfg(not(kani))]
            exhaustive: $name::<$crate::engines::Exhaustive>,
            #[cfg(not(kani))]
            random: $name::<$crate::engines::Random>,
            #[cfg(kani)]
            recorded: $name::<$crate::stub::Recorder>,
        }),+];

        #[cfg(kani)]
        #[cfg_attr(kani_stub, allow(dead_code))]
        mod kani_proofs {
            $($crate::kani_harness! { $kani $how, $name, [$($cover),+] })+
        }
    };
}

/// Why Kani cannot judge a theorem; none where it can.
#[cfg(any(not(kani), all(kani_stub, test)))]
#[macro_export]
macro_rules! reason_without_kani {
    (unwind $bound:literal) => {
        None
    };
    (not_for_kani $reason:literal) => {
        Some($reason)
    };
}

/// Kani's harness of a theorem; none where Kani cannot judge it.
#[cfg(kani)]
#[macro_export]
macro_rules! kani_harness {
    (not_for_kani $reason:literal, $name:ident, [$($cover:literal),+]) => {};
    (unwind $unwind:literal, $name:ident, [$($cover:literal),+]) => {
        #[cfg_attr(not(kani_stub), kani::proof, kani::unwind($unwind))]
        fn $name() {
            const { assert!($unwind > [$($cover),+].len(), "Kani's loop over the covers") };
            // Constants: Kani shall not work them out.
            let labels = const { [$($crate::source::Label::new($cover)),+] };
            let mut symbols = $crate::kani_source::Symbols::new(labels);
            // A failed claim panics, and no case is vacuous: Kani assumes.
            let _ = super::$name(&mut symbols);
            let mut _cover = 0;
            $(
                #[cfg(not(kani_stub))]
                kani::cover!(symbols.reached(_cover), $cover);
                _cover += 1;
            )+
        }
    };
}
