//! `--auto`: the triangle test that a scene needs.

use crate::args::SceneArgs;
use crate::progress::Progress;
use anyhow::Result;
use saarcor_studies::accuracy::scene::{self, Budget};
use saarcor_studies::world::{World, WorldOptions};

/// Whether the triangle test is chosen by the scene.
#[derive(Clone, Debug, clap::Args)]
pub struct AutoArgs {
    /// Takes the cheapest triangle test whose errors on the scene's primary rays stay inside: wrong
    /// answers in a million, and ulps that 99.9 % of the distances may be off [default: 10, fewer than
    /// eight pixels of a picture]
    #[arg(long, value_name = "WRONG[,ULP]", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "10", conflicts_with = "kernel")]
    auto: Option<Budget>,
}

impl AutoArgs {
    /// The scene made ready for the triangle test that was named or, with `--auto`, that it needs: says
    /// on `progress` which that is.
    ///
    /// # Errors
    /// Those of [`World::open`], and if no test stays inside the budget.
    pub fn open(&self, scene: &SceneArgs, last_frame: Option<usize>, progress: &Progress) -> Result<World> {
        let options = scene.options(last_frame)?;
        let Some(budget) = self.auto else { return Ok(World::open(&options, progress)?) };
        let options = WorldOptions { kernel: scene::KERNEL, ..options };
        let world = World::open_choosing(&options, progress, |world| {
            let (kernel, row) = progress
                .during(&format!("{}: triangle tests", world.name), |_| scene::cheapest(world, budget))?;
            progress.say(format_args!(
                "--auto: the triangle test {} is enough: {} wrong of {} primary rays, 99.9 % of the distances within \
                 {:.1} ulp",
                row.kernel,
                row.wrong(),
                row.cases,
                row.t_ulp_p999
            ));
            Ok(kernel)
        })?;
        Ok(world)
    }
}
