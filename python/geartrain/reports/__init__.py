"""Results as a report: a document for others, as PDF or HTML."""
