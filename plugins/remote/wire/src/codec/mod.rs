//! Bytes to values and back.

mod range;
mod reader;
mod residual;
mod writer;

pub(crate) use range::{BitCoder, RangeDecoder, RangeEncoder};
pub(crate) use reader::Reader;
pub(crate) use residual::{Context, Residuals, class, coarse};
pub(crate) use writer::Writer;
