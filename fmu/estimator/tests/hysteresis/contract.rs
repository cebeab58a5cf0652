//! What the bank promises as every estimator does.
