//! How each figure and table is drawn; what it is a sweep of, the server knows.

use super::data::Data;
use super::drawing::Drawing;
use super::{beams, curves, grains, inside, memory};
use granary_server::figures;

/// What a figure is drawn from, beyond the rows of its sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Needs {
    /// Nothing.
    Results,
    /// The records of its bendings, and the inside of its beams where that was analyzed.
    Records,
    /// These, and the snapshots of single grains.
    Grains,
    /// The signals and records of its recalls.
    Signals,
}

/// How a figure comes to paper.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shown {
    /// As a picture and files of its numbers.
    Picture(fn(&Data) -> Drawing),
    /// As a table of its sets beside the published one.
    Table,
}

/// A figure or table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figure {
    /// What the command line calls it.
    pub(crate) name: &'static str,
    pub(crate) needs: Needs,
    pub(crate) shown: Shown,
}

impl Figure {
    /// The sweep behind it.
    pub(crate) fn sweep(&self) -> &'static figures::Figure {
        figures::Figure::named(self.name).expect("a test finds every figure among the server's")
    }

    /// The figure called `name`.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        ALL.iter().find(|figure| figure.name == name)
    }
}

const fn figure(name: &'static str, needs: Needs, shown: Shown) -> Figure {
    Figure { name, needs, shown }
}

use Needs::{Grains, Records, Results, Signals};
use Shown::{Picture, Table};

/// All, in the server's order.
pub(crate) const ALL: &[Figure] = &[
    figure("fig3", Results, Picture(beams::coordination)),
    figure("fig4", Records, Picture(inside::pair_correlation)),
    figure("fig5", Records, Picture(curves::stress_strain)),
    figure("fig6", Results, Picture(beams::maps)),
    figure("fig7", Results, Picture(beams::maps)),
    figure("fig8", Results, Picture(beams::over_friction)),
    figure("fig9", Records, Picture(curves::forces)),
    figure("fig10", Records, Picture(inside::displacement)),
    figure("fig11", Grains, Picture(grains::non_affine)),
    figure("fig12", Records, Picture(inside::autocorrelation)),
    figure("fig13", Grains, Picture(grains::non_affine_over_change)),
    figure("fig14", Records, Picture(inside::height)),
    figure("fig15", Records, Picture(inside::height_and_friction)),
    figure("fig16", Records, Picture(inside::over_stress_of_all)),
    figure("table1", Results, Table),
    figure("memory-4", Signals, Picture(memory::pressures)),
    figure("memory-6", Signals, Picture(memory::signals)),
    figure("memory-8", Results, Picture(memory::over_friction)),
    figure("memory-9", Signals, Picture(memory::laws)),
    figure(
        "memory-11",
        Results,
        Picture(memory::fidelity_over_compression),
    ),
    figure("memory-11-inset", Results, Picture(memory::over_shape)),
    figure(
        "memory-12a",
        Results,
        Picture(memory::gain_over_compression),
    ),
    figure("memory-12b", Results, Picture(memory::over_size)),
    figure("memory-13", Signals, Picture(memory::words)),
    figure("memory-14", Results, Picture(memory::over_words)),
];
