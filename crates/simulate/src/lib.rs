//! truepose-simulate
