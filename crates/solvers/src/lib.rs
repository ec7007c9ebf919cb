//! truepose-solvers
