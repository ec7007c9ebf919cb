//! Kernels of dense matrices that others need as well: of some hundreds of columns, on one thread.

pub use crate::dense::{
    cholesky_lower, cross, gram, product, solve_lower_many, solve_upper_many, symmetric_eigen,
};
