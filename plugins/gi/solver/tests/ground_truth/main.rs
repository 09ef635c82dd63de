//! The path tracer against answers that are known without it: analytic scenes, conservation laws,
//! an independent renderer, and its own statistics.

mod build;
mod check;
mod closed;
mod cut_out;
mod emitters;
mod form_factors;
mod lights;
mod probes;
mod statistics;
