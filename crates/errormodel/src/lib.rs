//! truepose-errormodel
