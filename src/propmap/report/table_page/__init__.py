"""The page on a table: verdict, envelope, certificate, loads, the hover model beside."""
